#pragma once

#include <nlohmann/json.hpp>
#include <vector>

#include "experiment/experiment_record.h"
#include "experiment/map_files.h"
#include "experiment/pieces.h"

namespace truescatter {

// results.json, but for what it says of the program and the machine, out of finished pieces, every one of
// which is there. Throws Error (run): see PieceStore.
nlohmann::json join_pieces(const ExperimentRecord& record, const PieceStore& pieces);

// The ends of all error maps' colours: the median over the runs of the error's 99 % quantile, rounded up, and
// another one for the steps of ladders, which are smaller. The worst method's maps saturate; scaled to the
// worst, the good ones would be black.
MapRanges common_ranges(const nlohmann::json& results);

// Which pictures the views of all scenes have, of the first scene first.
std::vector<ViewPictures> pictures_of(const ExperimentRecord& record, const PieceStore& pieces);

}  // namespace truescatter
