// SPDX-License-Identifier: Apache-2.0
#include "palpate/bridge/estimator_node.hpp"

#include "bridge/bridge_fixture.hpp"
#include "palpate/core/error.hpp"
#include "palpate/geometry/objects/known_object.hpp"
#include "palpate/geometry/objects/object_model.hpp"
#include "palpate/hand/shadow.hpp"

namespace palpate::bridge {
namespace {

class EstimatorNodeTest : public DdsTest {};

TEST_F(EstimatorNodeTest, NeedsTheHandsLinks) {
  Participant here(domain_);
  const geometry::ObjectModel object(geometry::load_known_object("box"));
  const hand::Description hand = hand::shadow_hand();
  EXPECT_THROW(EstimatorNode(here, object, hand), BadInput);
}

}  // namespace
}  // namespace palpate::bridge
