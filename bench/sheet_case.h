/// One run of the macro-benchmark: a scene on n × n nodes with an integrator and a solver.
#pragma once

#include <cstdint>
#include <string>

#include <nlohmann/json.hpp>

namespace deform::bench {

struct SheetCase {
  std::string scene;       ///< "hanging", "sheet_p_1e-6" or "sheet_p_1e-4"
  std::int64_t nodes = 0;  ///< a side
  std::string integrator;
  std::string solver;       ///< a plugin, or "automatic"
  int threads = 1;          ///< at most, of TBB
  long steps = 0;           ///< at most; 0: all of the first 0.4 s
  double tolerance = 0;     ///< of Newton's method; 0: the integrator's own
  double newton_error = 0;  ///< that Newton's method may leave, in sides of the sheet
};

[[nodiscard]] nlohmann::json description(const SheetCase& c);
/// Measures in this process: `ms` a step (median, quartiles, first), `parts_ms` by StepTimes,
/// `newton` iterations a step, `lowest` point [m] at 0.1, 0.2, 0.3, 0.4 s as far as they are
/// reached, median `allocations` a step, peak `memory` [bytes a node] beyond that of the loaded
/// plugins, `status` "done" or why not, `reached` [s]. The first step makes the matrix's pattern;
/// the figures of a step leave it out. Throws what reading a scene does.
[[nodiscard]] nlohmann::json measure(const SheetCase& c);

}  // namespace deform::bench
