// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "rastro/sensor/source.h"

namespace rastro {

/// Whether a program that is given the recording should say that its input is wrong.
enum class WarningDue : std::uint8_t { no, either, yes };

/// One way in which a recording can be wrong, for tests of what a method says to it.
struct DisturbanceKind {
  std::string name;           ///< "baseline".
  std::string value;          ///< What its value is, such as "FACTOR"; empty: it has none.
  std::string default_value;  ///< Used where none is given; empty: a value is required, or there is none.
  std::string summary;        ///< One line.
  WarningDue warning_due = WarningDue::yes;
};

/// Every kind, in the order of the documentation.
const std::vector<DisturbanceKind>& disturbance_kinds();

/// Of NAME or NAME=VALUE. Error as check_disturbance().
WarningDue warning_due(const std::string& assignment);

/// Error unless `assignment` is NAME or NAME=VALUE of a kind; names the nearest kind.
void check_disturbance(const std::string& assignment);

/// The source with frames and calibration made wrong as `assignment` says, NAME or NAME=VALUE. The same frames for the
/// same source, always. Error for a wrong assignment, and where the source lacks what is to be disturbed.
std::unique_ptr<Source> disturbed(std::unique_ptr<Source> source, const std::string& assignment);

}  // namespace rastro
