#include "report/report.h"
#include "core/file.h"
namespace truescatter {
void write_report(const std::filesystem::path& folder) { write_text_file(folder / "report.html", "<html></html>"); }
}  // namespace truescatter
