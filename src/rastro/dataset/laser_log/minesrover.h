// SPDX-License-Identifier: Apache-2.0
// Internal: not installed.
#pragma once

#include <optional>
#include <string_view>

#include "rastro/dataset/laser_log/log_parser.h"

namespace rastro {

/// Logs of the Paris Mines rover that tinySLAM was published with (Steux and El Hamzaoui 2010): one scan a line, no
/// header, of two kinds that the number of columns tells apart. Column 0 is the time in microseconds, the last 682 are
/// the ranges of a Hokuyo URG-04LX in millimeters, counterclockwise, steps 44 to 725 of 1024 a revolution, 384 ahead.
/// The scanner's codes below 20 mm (0: nothing measured) say nothing of what is there: such a beam is broken, not free.
/// - 707 columns: 2 and 3 count the left and the right wheel. The log does not say what a count is. Fitted to the
///   recordings themselves (scans 0.6 s apart laid over each other, five logs: 0.228 to 0.245 mm, 318 to 368 mm and
///   75 to 140 mm) it is 0.23 mm, the wheels stand 330 mm apart, and the scanner 100 mm before them: odometry good to
///   some 5 %.
/// - 695 columns: 3 to 5 are x and y in meters and the heading in degrees, counterclockwise, as the rover kept them.
class MinesroverParser final : public LogParser {
 public:
  std::optional<Frame> read(std::string_view line, const LinePosition& position) override;
  void start_over(SourceInfo& info) override;

 private:
  struct Wheels {
    double left = 0.0, right = 0.0;  ///< Counts.
  };
  void integrate_wheels(const Wheels& wheels);

  std::optional<Wheels> last_wheels_;
  SE2 odometry_from_body_;
};

/// Whether the front of a text looks like such a log.
bool looks_like_minesrover(std::string_view front);

}  // namespace rastro
