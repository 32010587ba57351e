#include <gtest/gtest.h>

#include <cmath>

#include "config/experiment_spec.h"
#include "experiment/run_experiment.h"
#include "support/error_of.h"
#include "support/plane_experiment.h"
#include "support/temp_dir.h"

namespace truescatter::test {
namespace {

// A source whose results have been tampered with.
class TamperedSource : public LayerSource {
 public:
  using Tamper = std::function<void(std::vector<ComputedLayer>&)>;

  TamperedSource(std::unique_ptr<LayerSource> honest, Tamper tamper)
      : honest_(std::move(honest)), tamper_(std::move(tamper)) {}

  std::vector<ComputedLayer> compute(std::span<const TruthLayer> layers,
                                     const std::function<void(std::size_t)>& advance) const override {
    std::vector<ComputedLayer> computed = honest_->compute(layers, advance);
    tamper_(computed);
    return computed;
  }
  TruthValues audit_values(std::span<const std::uint32_t> chosen,
                           std::span<const TruthLayer> layers) const override {
    return honest_->audit_values(chosen, layers);
  }
  double tail_bound() const override { return honest_->tail_bound(); }
  double largest_irradiance() const override { return honest_->largest_irradiance(); }
  std::size_t point_count() const override { return honest_->point_count(); }
  bool computes_together() const override { return honest_->computes_together(); }
  std::string content_key() const override { return honest_->content_key(); }

 private:
  std::unique_ptr<LayerSource> honest_;
  Tamper tamper_;
};

// The same, where the engine that audits errs too.
class TwiceTamperedSource : public TamperedSource {
 public:
  TwiceTamperedSource(std::unique_ptr<LayerSource> honest, double shift)
      : TamperedSource(std::move(honest),
                       [shift](std::vector<ComputedLayer>& computed) {
                         for (ComputedLayer& layer : computed) shift_light(layer.values, shift);
                       }),
        shift_(shift) {}

  TruthValues audit_values(std::span<const std::uint32_t> chosen,
                           std::span<const TruthLayer> layers) const override {
    TruthValues values = TamperedSource::audit_values(chosen, layers);
    for (std::vector<Vec4d>& layer : values) shift_light(layer, shift_);
    return values;
  }

 private:
  static void shift_light(std::vector<Vec4d>& values, double shift) {
    for (Vec4d& value : values) value[0] += shift;
  }

  double shift_;
};

const std::string kExperiment = kPlane + R"(
[[profile]]
name = "spike-and-base"
[[method]]
name = "none"
[[method]]
name = "texture-space"
settings.texture_size = 64
[truth]
audit_points = 576
)";

class FailedAudit : public testing::Test {
 protected:
  // Runs the experiment with results of one kind tampered with.
  std::optional<Error> run(LayerKind kind, const TamperedSource::Tamper& tamper,
                           TruthCache* cache = nullptr) const {
    const ExperimentSpec spec = read_experiment(folder_.write("e.toml", kExperiment));
    return error_of([&] {
      run_experiment(spec, out_.path(), cache, [&](LayerKind of, std::unique_ptr<LayerSource> honest) {
        return of == kind ? std::make_unique<TamperedSource>(std::move(honest), tamper) : std::move(honest);
      });
    });
  }

  // All that there is says what the view shows.
  void expect_nothing_ranked() const {
    EXPECT_EQ(out_.names().size(), 2U);
    EXPECT_TRUE(std::filesystem::is_empty(out_.path() / "maps"));
    std::set<std::string> pieces;
    for (const auto& piece : std::filesystem::directory_iterator(out_.path() / "pieces"))
      pieces.insert(piece.path().filename().string());
    EXPECT_EQ(pieces, (std::set<std::string>{"key.json", "view.front.exr", "view.front.json"}));
  }

  TempDir folder_;
  TempDir out_;
};

// What is wrong by more than the tolerance at a single one of the audited points ends the run with exit code
// 3 and nothing is ranked. Largest irradiance: cos(atan 0.5) = 0.89.
TEST_F(FailedAudit, EndsTheRunWithThreeAndRanksNothing) {
  for (const LayerKind kind : {LayerKind::euclidean, LayerKind::geodesic}) {
    const std::optional<Error> error =
        run(kind, [](std::vector<ComputedLayer>& computed) { computed.back().values[300][1] += 3e-4; });
    ASSERT_TRUE(error);
    EXPECT_EQ(error->exit_code(), 3);
    const std::string name = kind == LayerKind::geodesic ? "the geodesic truth" : "the truth";
    EXPECT_TRUE(
        std::string(error->what()).starts_with("the audit of " + name + " failed: at standard deviation "))
        << error->what();
    EXPECT_TRUE(std::string(error->what()).ends_with("nothing is ranked")) << error->what();
    expect_nothing_ranked();
  }
}

TEST_F(FailedAudit, IsWhatAValueThatIsNoNumberLeadsTo) {
  const std::optional<Error> error = run(LayerKind::euclidean, [](std::vector<ComputedLayer>& computed) {
    computed.front().values[0][3] = std::numeric_limits<double>::quiet_NaN();
  });
  ASSERT_TRUE(error);
  EXPECT_EQ(error->exit_code(), 3);
  expect_nothing_ranked();
}

std::size_t files_in(const TempDir& folder) { return folder.names().size(); }

// Nothing that failed is kept, so the next run is not spoilt.
TEST_F(FailedAudit, LeavesNothingInTheCache) {
  const TempDir folder;
  TruthCache cache(folder.path(), 1 << 24);
  EXPECT_TRUE(run(
      LayerKind::euclidean,
      [](std::vector<ComputedLayer>& computed) { computed.front().values[7][3] += 1e-3; }, &cache));
  EXPECT_EQ(files_in(folder), 0U);
  EXPECT_FALSE(run(
      LayerKind::euclidean, [](std::vector<ComputedLayer>&) {}, &cache));
  EXPECT_GT(files_in(folder), 0U);
}

// A layer in the cache that is whole but wrong, as an engine's earlier version may have left it: it fails its
// audit, that is said, and it is computed again, once.
TEST_F(FailedAudit, OfACachedTruthComputesItAgain) {
  const TempDir folder;
  TruthCache cache(folder.path(), 1 << 24);
  const auto honest = [](std::vector<ComputedLayer>&) {};
  ASSERT_FALSE(run(LayerKind::euclidean, honest, &cache));
  for (const std::string& name : folder.names()) {
    const std::string key = name.substr(0, name.find('.'));
    std::optional<CachedLayer> layer = cache.find(key, 576);
    ASSERT_TRUE(layer) << name;
    for (Vec4d& value : layer->values) value[0] += 1e-3;
    cache.store(key, *layer);
  }
  for (const bool spoilt : {true, false}) {
    testing::internal::CaptureStderr();
    EXPECT_FALSE(run(LayerKind::euclidean, honest, &cache));
    const std::string said = testing::internal::GetCapturedStderr();
    for (const char* what : {"the truth", "the geodesic truth"}) {
      const std::string note =
          std::string("note: ") + what + " in the cache fails its audit; it is computed again\n";
      EXPECT_EQ(said.find(note) != std::string::npos, spoilt) << said;
    }
  }
}

// What the audit of the Gaussians cannot see: both engines off by the same. The weights of the dipole's
// Gaussians are positive and sum to its albedo, 0.79, so a shift of 1e-3 shifts the profile's truth by
// 0.79e-3 of the light, which is above the 1e-4 of the tolerance and the 2e-5 of the mixture; a shift of 1e-5
// is not.
TEST_F(FailedAudit, OfAProfilesMixtureEndsTheRunWithThree) {
  const std::string of =
      "[profile.of]\nmodel = \"classical-dipole\"\nsigma_a = 0.0041\nsigma_s_prime = 2.62\neta = 1.5\n";
  std::string experiment = kExperiment;
  experiment.insert(experiment.find("[[method]]"), of);
  const ExperimentSpec spec = read_experiment(folder_.write("e.toml", experiment));
  for (const double shift : {1e-5, 1e-3}) {
    const std::optional<Error> error = error_of([&] {
      run_experiment(spec, out_.path(), nullptr, [&](LayerKind of_kind, std::unique_ptr<LayerSource> honest) {
        return of_kind == LayerKind::euclidean
                   ? std::make_unique<TwiceTamperedSource>(std::move(honest), shift)
                   : std::move(honest);
      });
    });
    ASSERT_EQ(error.has_value(), shift == 1e-3);
    if (!error) {
      std::filesystem::remove_all(out_.path());
      std::filesystem::create_directory(out_.path());
      continue;
    }
    EXPECT_EQ(error->exit_code(), 3);
    EXPECT_TRUE(std::string(error->what())
                    .starts_with("the audit of the profile of 'spike-and-base' failed: its mixture of "
                                 "Gaussians is off by "))
        << error->what();
    expect_nothing_ranked();
  }
}

// The seam itself changes nothing: the same run, untouched, is through.
TEST_F(FailedAudit, DoesNotHappenToHonestResults) {
  const std::optional<Error> error = run(LayerKind::euclidean, [](std::vector<ComputedLayer>&) {});
  EXPECT_FALSE(error) << error->what();
  EXPECT_TRUE(std::filesystem::exists(out_.path() / "results.json"));
}

}  // namespace
}  // namespace truescatter::test
