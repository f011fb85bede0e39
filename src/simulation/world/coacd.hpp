// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

// The C interface of CoACD 1.0, which its wheel ships without a header.
extern "C" {

struct CoACD_Mesh {
  double* vertices_ptr;
  std::uint64_t vertices_count;
  int* triangles_ptr;
  std::uint64_t triangles_count;
};

struct CoACD_MeshArray {
  CoACD_Mesh* meshes_ptr;
  std::uint64_t meshes_count;
};

CoACD_MeshArray CoACD_run(const CoACD_Mesh* input, double threshold, int max_convex_hull,
                          int preprocess_mode, int preprocess_resolution, int sample_resolution,
                          int mcts_nodes, int mcts_iterations, int mcts_max_depth, bool pca,
                          bool merge, bool decimate, int max_hull_vertices, bool extrude,
                          double extrude_margin, int approximation_mode, unsigned seed,
                          bool real_metric);
void CoACD_freeMeshArray(CoACD_MeshArray parts);
void CoACD_setLogLevel(const char* level);
}
