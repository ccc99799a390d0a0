// SPDX-License-Identifier: Apache-2.0
// How often named faults of a calibration are named, and right calibrations doubted, over generated boards of several
// seeds: rastro_bench_calibration_faults [FIRST_SEED [SEEDS]]. A doubt about coverage or uncertainty says what views
// lack, and is counted apart: it is no fault.
#include <fmt/format.h>

#include <algorithm>
#include <cstdlib>
#include <string>
#include <string_view>
#include <vector>

#include "rastro/calibration/boards_testing.h"
#include "rastro/calibration/trust.h"

namespace {

using namespace rastro;

bool says(const CalibrationTrust& trust, std::string_view words) {
  return std::any_of(trust.doubts.begin(), trust.doubts.end(),
                     [&](const std::string& doubt) { return doubt.find(words) != doubt.npos; });
}

/// Doubts that accuse the board, the model or the images.
std::string accusations(const CalibrationTrust& trust) {
  std::string text;
  for (const std::string& doubt : trust.doubts)
    if (!doubt.starts_with("missing:") && !doubt.starts_with("projections are uncertain")) text += "\n    " + doubt;
  return text;
}

CalibrationTrust judge(const GeneratedOptions& made, const CalibrationOptions& options = {}) {
  const GeneratedBoards boards = generate_boards(made);
  return judge_calibration(calibrate_camera(boards.input, options), 0, 640, 480);
}

/// The baseline of a pair tells it.
CalibrationTrust judge_square_size(std::uint64_t seed, double factor) {
  GeneratedBoards boards = generate_boards({.seed = seed, .frames = 30, .stereo = true});
  for (Eigen::Vector2d& point : boards.input.board) point *= factor;
  CalibrationTrust trust;
  judge_baseline(calibrate_camera(boards.input, {.model = LensModel::pinhole_4, .compare_models = false}),
                 boards.truth.right_from_left.inverse().translation().norm(), trust);
  return trust;
}

struct Tally {
  std::string_view name;
  int of = 0, named = 0;
  void count(bool yes) {
    ++of;
    named += yes ? 1 : 0;
  }
  void print() const { fmt::print("{:<44} {} of {}\n", name, named, of); }
};

void count_faults(std::uint64_t first, std::uint64_t seeds) {
  Tally size{"squares 3 % too large, named"}, right_size{"right size of squares, doubted"},
      bowed{"board bowed by 1.5 mm, named"}, simple{"4 coefficients for a lens of 8, named"},
      middle{"all boards in the middle, named"};
  for (std::uint64_t seed = first; seed < first + seeds; ++seed) {
    size.count(says(judge_square_size(seed, 1.03), "wrong square size"));
    right_size.count(!judge_square_size(seed, 1.0).doubts.empty());
    bowed.count(says(judge({.seed = seed, .frames = 40, .shape = {0.0015, -0.0008, 0.0}}), "board is not flat"));
    simple.count(says(judge({.model = LensModel::pinhole_8, .seed = seed}, {.model = LensModel::pinhole_4}),
                      "model is too simple"));
    middle.count(says(judge({.seed = seed, .only_middle = true}), "everything but the center"));
  }
  for (const Tally& tally : {size, right_size, bowed, simple, middle}) tally.print();
}

void count_false_doubts(std::uint64_t first, std::uint64_t seeds) {
  Tally accused{"right calibrations, board, model or images accused"};
  std::vector<Tally> lacking;
  for (const LensModel model :
       {LensModel::pinhole_4, LensModel::pinhole_5, LensModel::equidistant, LensModel::pinhole_8}) {
    lacking.push_back({lens_model_name(model)});
    for (std::uint64_t seed = first; seed < first + seeds; ++seed) {
      const CalibrationTrust trust = judge({.model = model, .seed = seed, .frames = 40});
      const std::string wrong = accusations(trust);
      accused.count(!wrong.empty());
      lacking.back().count(!trust.doubts.empty() && wrong.empty());
      if (!wrong.empty()) fmt::print("  {}, seed {}:{}\n", lens_model_name(model), seed, wrong);
    }
  }
  accused.print();
  fmt::print("views said to lack, or projections uncertain:\n");
  for (const Tally& tally : lacking) tally.print();
}

}  // namespace

int main(int argc, char** argv) {
  const std::uint64_t first = argc > 1 ? std::strtoull(argv[1], nullptr, 10) : 101;
  const std::uint64_t seeds = argc > 2 ? std::strtoull(argv[2], nullptr, 10) : 10;
  count_faults(first, seeds);
  count_false_doubts(first, seeds);
}
