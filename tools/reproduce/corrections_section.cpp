// The equations that are wrong in print.
#include <fmt/format.h>

#include <map>

#include "tools/reproduce/corrections.h"
#include "tools/reproduce/experiments.h"

namespace umax {

ReportSection corrected_equations(Workbench&) {
  ReportTable table{.name = "equations",
                    .caption =
                        "Each equation as printed and as corrected, against finite differences or a closed form, "
                        "computed when this report was made.",
                    .columns = {{"printed"},
                                {"correct"},
                                {"error"},
                                {"as printed, mean"},
                                {"least"},
                                {"largest"},
                                {"as corrected, largest"},
                                {"samples"},
                                {"remark"},
                                {"proved by the test"}},
                    .rows = {}};
  std::map<std::string, int> seen;
  for (const Correction& row : corrections())
    table.rows.push_back({fmt::format("{} ({})", row.equation, ++seen[row.equation]),
                          {{row.printed},
                           {row.corrected},
                           {row.measure},
                           number_cell(row.error_printed),
                           number_cell(row.lowest_printed),
                           number_cell(row.highest_printed),
                           number_cell(row.error_corrected, 2),
                           number_cell(row.num_samples, 6),
                           {row.remark},
                           {row.test}}});
  return {.name = "corrections", .title = "The paper's equations, corrected", .blocks = {table}};
}

}  // namespace umax
