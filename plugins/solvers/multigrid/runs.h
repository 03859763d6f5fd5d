/// Products of vectors of nodes with matrices of alike rows: interpolation, and its transpose.
#pragma once

#include <vector>

#include "alike_rows.h"
#include "field.h"

namespace multigrid {

/// Rows that are alike are taken as a run, each a step of rows and of columns after the one before:
/// between a grid and one of half as many nodes a side, every second row, or column.
class Runs {
 public:
  Runs() = default;
  explicit Runs(const AlikeRows& rows);

  /// Runs that have the rows row … row+size−1 among them.
  struct Task {
    Index row, size;
    std::size_t run, run_end;
  };
  [[nodiscard]] const std::vector<Task>& tasks() const { return tasks_; }
  /// y = M x on the rows of a task, or y += M x.
  void multiply(const Task& task, const Field<float>& x, Field<float>& y, bool adds) const;

  struct Run {
    std::int32_t row, row_step, size, column, column_step;
    std::uint32_t share, share_end;  // in shares_
  };

 private:
  void take_runs(const AlikeRows& rows);
  [[nodiscard]] Run longest_run(const AlikeRows& rows, std::int32_t row,
                                const std::vector<bool>& is_taken) const;
  void make_tasks();

  std::vector<Run> runs_;
  std::vector<AlikeRows::Entry> shares_;
  std::vector<Task> tasks_;
};

}  // namespace multigrid
