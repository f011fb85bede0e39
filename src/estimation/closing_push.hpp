// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "palpate/estimation/event_log.hpp"

namespace palpate::estimation {

/// m by which a fingertip of the closing hand went on after it had met the object, along the
/// object's normal: the farthest of all. The object has moved by up to as much.
/// @param closed  reading at which the hand had closed
double closing_push(const hand::Description& hand, const EventLog& log, std::size_t closed);

}  // namespace palpate::estimation
