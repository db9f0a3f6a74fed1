#include "core/elimination_order.h"

#include <cholmod.h>

#include <algorithm>
#include <new>

#include "core/system_matrix.h"

namespace umax {
namespace {

// nested dissection pays from here on; below, minimum degree does as well and is found faster
constexpr int nested_dissection_nodes = 2000;

}  // namespace

std::vector<int> elimination_order(const Model& model, const std::vector<int>& last) {
  std::vector<int> column_starts{0}, row_indices;
  for (const std::vector<int>& list : later_neighbours(model.hexes, model.num_nodes())) {
    row_indices.insert(row_indices.end(), list.begin(), list.end());
    column_starts.push_back(int(row_indices.size()));
  }
  cholmod_sparse graph{};  // of the nodes, lower triangle
  graph.nrow = graph.ncol = std::size_t(model.num_nodes());
  graph.nzmax = row_indices.size();
  graph.p = column_starts.data();
  graph.i = row_indices.data();
  graph.stype = -1;
  graph.itype = CHOLMOD_INT;
  graph.xtype = CHOLMOD_PATTERN;
  graph.sorted = graph.packed = 1;

  cholmod_common common{};
  cholmod_start(&common);
  common.print = 0;
  common.error_handler = nullptr;
  std::vector<int> order(graph.ncol);
  const bool ordered = model.num_nodes() < nested_dissection_nodes
                           ? cholmod_amd(&graph, nullptr, 0, order.data(), &common)
                           : cholmod_metis(&graph, nullptr, 0, true, order.data(), &common);
  std::stable_partition(order.begin(), order.end(),
                        [&](int node) { return !std::binary_search(last.begin(), last.end(), node); });
  // the symbolic factor's own order is the postordered one
  common.nmethods = 1;
  common.method[0].ordering = CHOLMOD_GIVEN;
  common.postorder = 1;
  common.supernodal = CHOLMOD_SIMPLICIAL;
  cholmod_factor* factor = ordered ? cholmod_analyze_p(&graph, order.data(), nullptr, 0, &common) : nullptr;
  if (factor) std::copy_n(static_cast<const int*>(factor->Perm), order.size(), order.begin());
  const bool done = factor != nullptr;
  cholmod_free_factor(&factor, &common);
  cholmod_finish(&common);
  if (!done) throw std::bad_alloc();
  return order;
}

}  // namespace umax
