// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

struct ddsi_sertype;

namespace palpate::bridge {

/// A type of DDS whose samples are std::string, the message in CDR as it goes over the wire; for
/// types without a key. The caller owns a reference.
ddsi_sertype* make_raw_sertype(const std::string& type_name);

}  // namespace palpate::bridge
