// SPDX-License-Identifier: Apache-2.0
#include "simulation/hand/geom_mesh.hpp"

#include <gtest/gtest.h>

#include "palpate/core/file.hpp"
#include "palpate/geometry/mesh/mass_properties.hpp"
#include "simulation/hand/hand_spec.hpp"

namespace palpate::simulation {
namespace {

TEST(GeomMesh, HasTheShapeAndSizeOfTheGeom) {
  const std::string file = testing::TempDir() + "drawn.xml";
  write_file_atomically(file, R"(<mujoco><worldbody><body name="palm">
      <geom type="box" size="0.04 0.03 0.01"/>
      <body name="one" pos="0.05 0 0"><joint name="j1" axis="0 1 0" range="0 1"/>
        <geom type="cylinder" size="0.009 0.02" pos="0 0 0.003"/>
        <geom type="ellipsoid" size="0.01 0.02 0.03"/>
        <body name="tip" pos="0.05 0 0"><joint name="j2" axis="0 1 0" range="0 1"/>
          <geom type="capsule" size="0.008 0.02"/><geom type="sphere" size="0.007"/>
        </body></body></body></worldbody></mujoco>)");
  const ModelHandle model = compile(*parse_model(file));
  const Eigen::Vector3d sizes[] = {{0.08, 0.06, 0.02},
                                   {0.018, 0.018, 0.04},
                                   {0.02, 0.04, 0.06},
                                   {0.016, 0.016, 0.056},
                                   {0.014, 0.014, 0.014}};
  ASSERT_EQ(model->ngeom, 5);
  for (int geom = 0; geom < model->ngeom; ++geom) {
    const auto mesh = geom_mesh(*model, geom);
    EXPECT_TRUE(geometry::bounds(mesh).sizes().isApprox(sizes[geom], 1e-6)) << geom;
    EXPECT_TRUE(geometry::bounds(mesh).center().isZero(1e-9)) << geom;
    EXPECT_GT(geometry::mass_properties(mesh, 1.0).volume, 0.5 * sizes[geom].prod())
        << geom;  // closed, outwards
  }
}

}  // namespace
}  // namespace palpate::simulation
