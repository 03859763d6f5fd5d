#include "simulation/report_memory.h"

#include <cmath>
#include <cstddef>
#include <vector>

#include "deform/error.h"

namespace deform {
namespace {

constexpr const char *kCounts = "report/counts", *kFigures = "report/figures",
                     *kResiduals = "report/residuals";

long count_of(double value) {
  if (!(value >= 0 && value < 0x1p53 && value == std::floor(value)))
    throw InputError("the checkpoint's \"report/counts\" are no counts");
  return static_cast<long>(value);
}

}  // namespace

void save_report(const StepReport& report, Memory& memory) {
  std::vector<double> counts;
  for (const long count :
       {report.iterations, report.projected, report.with_jacobian, report.contact_changes,
        report.solver_iterations, report.substeps, report.rejected})
    counts.push_back(static_cast<double>(count));
  memory.put(kCounts, counts);
  memory.put(kFigures, {report.smallest, report.largest, report.residual, report.potential_change});
  memory.put(kResiduals, report.residuals);
  report.contact.save(memory);
}

void load_report(StepReport& report, const Memory& memory, Index rows) {
  const std::vector<double>& counts = memory.get(kCounts, 7);
  std::size_t next = 0;
  for (long* count :
       {&report.iterations, &report.projected, &report.with_jacobian, &report.contact_changes,
        &report.solver_iterations, &report.substeps, &report.rejected})
    *count = count_of(counts[next++]);
  const std::vector<double>& figures = memory.get(kFigures, 4);
  report.smallest = figures[0];
  report.largest = figures[1];
  report.residual = figures[2];
  report.potential_change = figures[3];
  const auto residuals = memory.entries().find(kResiduals);
  if (residuals != memory.entries().end()) report.residuals = residuals->second;
  report.contact.load(memory, rows);
}

}  // namespace deform
