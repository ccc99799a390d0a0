// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cctype>
#include <cstdint>
#include <cstdlib>
#include <ostream>
#include <sstream>
#include <stdexcept>
#include <string>
#include <vector>

#include "rastro/base/text_file.h"

namespace rastro {

/// One line of tests/golden/accuracy.csv.
struct AccuracyRow {
  std::string method;               ///< An odometry or a SLAM method.
  std::string sensor;               ///< "mono", "stereo", "rgbd", "laser".
  std::string recording;            ///< A folder or log of RASTRO_DATA or "world:NAME".
  std::int64_t first = 0, end = 0;  ///< Its frames, written as "@FIRST:END" behind the recording; END is not included.
  std::string alignment;            ///< "se3", "sim3"; "relations": mean error of the relations of a laser log.
  double limit_m = 0.0, coverage_pct = 0.0, measured_m = 0.0;
  std::string why;

  bool is_generated() const { return recording.rfind("world:", 0) == 0; }
  /// For ctest: letters, digits and underscores.
  std::string name() const {
    std::string name = method + "_" + sensor + "_" + recording + "_" + std::to_string(first);
    for (char& c : name) c = std::isalnum(static_cast<unsigned char>(c)) ? c : '_';
    return name;
  }
};

/// For GoogleTest's messages.
inline void PrintTo(const AccuracyRow& row, std::ostream* out) { *out << row.name(); }

inline AccuracyRow parse_accuracy_row(const std::string& line) {
  std::vector<std::string> cells;
  std::stringstream stream(line);
  for (std::string cell; cells.size() < 7 && std::getline(stream, cell, ',');) cells.push_back(cell);
  std::string why;
  std::getline(stream, why);
  const std::size_t at = cells.size() == 7 ? cells[2].find('@') : std::string::npos;
  const std::size_t colon = at == std::string::npos ? at : cells[2].find(':', at);
  if (colon == std::string::npos || why.empty()) throw std::runtime_error("accuracy.csv: cannot read '" + line + "'");
  AccuracyRow row;
  row.method = cells[0];
  row.sensor = cells[1];
  row.recording = cells[2].substr(0, at);
  row.first = std::stoll(cells[2].substr(at + 1, colon - at - 1));
  row.end = std::stoll(cells[2].substr(colon + 1));
  row.alignment = cells[3];
  row.limit_m = std::stod(cells[4]);
  row.coverage_pct = std::stod(cells[5]);
  row.measured_m = std::stod(cells[6]);
  row.why = why;
  return row;
}

/// All rows of the file; its first line names the columns.
inline std::vector<AccuracyRow> read_accuracy_rows(const std::string& file) {
  const std::string text = read_text_file(file);
  std::vector<AccuracyRow> rows;
  for (const TextLine& line : content_lines(text)) {
    if (line.text.rfind("method,", 0) != 0) rows.push_back(parse_accuracy_row(std::string(line.text)));
  }
  return rows;
}

}  // namespace rastro
