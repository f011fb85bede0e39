// SPDX-License-Identifier: Apache-2.0
#include "robot_parts.hpp"

#include <fmt/format.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/vector.h>

#include <algorithm>
#include <stdexcept>

#include "libraries.hpp"
#include "palpate/tactile/contacts/contact_window.hpp"
#include "without_gil.hpp"

namespace palpate::python {
namespace {

namespace nb = nanobind;
using hand::ArmReading;
using hand::MountPosition;
using hand::TipContact;

/// Python's answer, made of it by `convert`, with the GIL.
template <class Part, class Convert, class... Arguments>
auto answer_of(const Part& part, Raised& raised, const char* method, const Convert& convert,
               const Arguments&... arguments) {
  const WithGil acquire;
  try {
    return convert(nb::find(part).attr(method)(arguments...));
  } catch (const nb::python_error& error) {
    raised.keep(error);
  }
}

[[noreturn]] void refuse(const char* method, const char* wanted, nb::handle answer) {
  throw std::runtime_error(
      fmt::format("{}() returned {}, not {}", method, nb::repr(answer).c_str(), wanted));
}

/// Contacts, or a list of TipContact.
std::vector<TipContact> tip_contacts(nb::handle answer) {
  std::vector<TipContact> contacts;
  if (nb::isinstance<Contacts>(answer)) {
    for (const tactile::Contact& contact : nb::cast<const Contacts&>(answer).list) {
      contacts.push_back(tactile::tip_contact(contact));
    }
  } else if (!nb::try_cast(answer, contacts)) {
    refuse("read", "Contacts, a list of TipContact, or None", answer);
  }
  return contacts;
}

}  // namespace

std::string one_line(const nb::python_error& error) {
  const std::string type = nb::cast<std::string>(error.type().attr("__name__"));
  std::string text = nb::cast<std::string>(nb::str(error.value()));
  text.resize(std::min(text.find('\n'), text.size()));
  return text.empty() ? type : fmt::format("{}: {}", type, text);
}

void Raised::keep(const nb::python_error& error) {
  if (!first.is_valid()) first = nb::borrow(error.value());
  throw std::runtime_error(one_line(error));
}

void PythonArm::move(const MountPosition& target) {
  answer_of(
      *this, raised, "move", [](const nb::object&) {}, target);
}

std::optional<ArmReading> PythonArm::read() {
  const auto convert = [](const nb::object& answer) -> std::optional<ArmReading> {
    if (answer.is_none()) return std::nullopt;
    if (!nb::isinstance<ArmReading>(answer)) refuse("read", "an ArmReading or None", answer);
    return nb::cast<ArmReading>(answer);
  };
  return answer_of(*this, raised, "read", convert);
}

hand::PathFeasibility PythonArm::check_path(std::span<const MountPosition> way) const {
  const auto convert = [](const nb::object& answer) -> hand::PathFeasibility {
    if (nb::isinstance<hand::PathFeasibility>(answer)) {
      return nb::cast<hand::PathFeasibility>(answer);
    }
    std::string obstacle;
    if (!nb::try_cast(answer, obstacle)) {
      refuse("check_path", "a string or a PathFeasibility", answer);
    }
    return {.obstacle = std::move(obstacle)};
  };
  return answer_of(*this, raised, "check_path", convert,
                   std::vector<MountPosition>(way.begin(), way.end()));
}

std::optional<std::vector<TipContact>> PythonSensor::read() {
  const auto convert = [](const nb::object& answer) -> std::optional<std::vector<TipContact>> {
    if (answer.is_none()) return std::nullopt;
    return tip_contacts(answer);
  };
  return answer_of(*this, raised, "read", convert);
}

}  // namespace palpate::python
