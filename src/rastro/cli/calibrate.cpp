// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <memory>

#include "rastro/base/append_file.h"
#include "rastro/base/error.h"
#include "rastro/base/log.h"
#include "rastro/base/output_path.h"
#include "rastro/base/text_file.h"
#include "rastro/calibration/report.h"
#include "rastro/camera/write_calibration.h"
#include "rastro/cli/calibrate_input.h"
#include "rastro/cli/command.h"
#include "rastro/cli/common_flags.h"
#include "rastro/cli/interrupt.h"
#include "rastro/cli/live_boards.h"
#include "rastro/cli/progress_bar.h"
#include "rastro/cli/scene_input.h"
#include "rastro/cli/server_flags.h"
#include "rastro/dataset/live/live.h"

namespace rastro::cli {
namespace {

constexpr double largest_usual_square_m = 0.5;  // beyond it, it was probably given in cm or mm

constexpr const char* calibrate_footer =
    R"(Estimates focal lengths, principal point and distortion from images of a board, with the standard deviation of each,
and says how far the result can be trusted: the uncertainty of projection over the image, two halves of the images against
each other, parts of the image and tilts that are missing, a board that is not flat, a model that is too simple.
20 to 50 sharp images, the board in every corner of the image and tilted by 20 to 45 degrees in each direction.

Boards, sizes in meters:
  chessboard:9x6:0.025          inner corners, side of a square; seen whole or not at all
  charuco:8x6:0.03:0.022        squares (the first is black), side of a square and of a tag; also seen in part.
                                :DICTIONARY 4x4_50 (default) to 7x7_1000
  apriltag:6x6:0.03:0.009       tags, side of a tag, gap between two; with black squares between as Kalibr's; also
                                seen in part. :FAMILY 36h11 (default), 36h10, 25h9, 16h5

Files in --out: camera.yaml (ROS; of a pair left.yaml, right.yaml), opencv.yaml, camchain.yaml (Kalibr; of pinhole4 and
equidistant alone: its models have four coefficients), calibration.json, residuals.png, uncertainty.png, corners.vnl (the corners used, as mrcal reads them). Each YAML can be given to --calibration of the other commands.
With --depth, camera.yaml also has depth_factor and depth_offset_m, which are used for recordings in TUM layout, ROS
bags and live depth cameras. Of a depth camera that does not register its depth to the color image, --depth-camera FILE tells the
lens (calibrate its infrared images); camera.yaml then has depth_camera and color_from_depth, and every command that is
given this file, or a recording in TUM layout with it in its folder, puts depth into the color image. --readout-time of a
rolling shutter is written into all files but Kalibr's.

DATA may be live (v4l2:, http:, replay:, ...): hold the board still where it is asked for; views are taken by themselves
until nothing is missing, or until Ctrl-C. A pair (--stereo, or --right with a second source) and a depth camera
(--depth) too: 20 views that both cameras see, or boards near and twice as far.

Examples:
  rastro calibrate --make-board chessboard:9x6:0.025 --out board.svg
  rastro calibrate --make-board apriltag:6x6:0.03:0.009 --out board.pdf
  rastro calibrate images/ --board chessboard:9x6:0.025 --out camera
  rastro calibrate walk.mp4 --every 10 --board chessboard:9x6:0.025 --out camera --model equidistant
  rastro calibrate v4l2:/dev/video0 --board charuco:8x6:0.03:0.022 --out camera
  rastro calibrate room/ --board chessboard:9x6:0.06 --depth --out camera
  rastro calibrate v4l2:/dev/video0 --board chessboard:9x6:0.025 --out camera --view
  rastro calibrate openni2: --board chessboard:9x6:0.06 --depth --out camera
  rastro calibrate room/ --board chessboard:9x6:0.06 --depth --depth-camera infrared/camera.yaml --out camera
  rastro calibrate v4l2:/dev/video0 --right v4l2:/dev/video2 --board charuco:8x6:0.03:0.022 --out pair
  rastro calibrate 'left*.jpg' --right 'right*.jpg' --board chessboard:9x6:0.025 --out pair --baseline 0.11)";

struct CalibrateFlags {
  DataFlags data;
  std::string board, make_board, right, out, model = "auto";
  double baseline_m = 0.0;
  std::size_t most_views = 100;
  bool stereo = false, depth = false;
  std::string depth_camera;
  bool force = false;
  bool view = false;
  ServerFlags server;
};

LensModel model_named(const std::string& name) {
  for (const LensModel model :
       {LensModel::pinhole_4, LensModel::pinhole_5, LensModel::equidistant, LensModel::pinhole_8})
    if (name == lens_model_name(model)) return model;
  throw Error(fmt::format("no model '{}'", name), "--model",
              "choose auto, pinhole4, pinhole5, pinhole8 or equidistant");
}

void refuse_existing_output(const CalibrateFlags& flags) {
  if (flags.out.empty()) throw Error("is missing", "--out", "say where the result goes");
  refuse_existing(flags.out, flags.force);
}

void make_board(const CalibrateFlags& flags) {
  const Board board = parse_board(flags.make_board);
  refuse_existing_output(flags);
  const bool pdf = flags.out.ends_with(".pdf");
  if (!pdf && !flags.out.ends_with(".svg")) throw Error("is neither .svg nor .pdf", flags.out, "name the file so");
  write_whole_file(flags.out, pdf ? board_pdf(board) : board_svg(board));
  if (!flags.data.quiet)
    fmt::print("{} written: print it at 100 %, glue it to something flat, measure it\n", flags.out);
}

void write_files(const CalibrationReport& report, const Board& board, const std::filesystem::path& folder) {
  const std::vector<CalibratedCameraEntry> cameras = calibrated_cameras(report);
  for (std::size_t camera = 0; camera < cameras.size(); ++camera) {
    write_whole_file(folder / (cameras[camera].name + ".yaml"), ros_calibration_text(cameras, camera));
    const std::string suffix = cameras.size() > 1 ? "_" + cameras[camera].name : "";
    // mrcal's boards are regular grids.
    if (board.kind != BoardKind::apriltag)
      write_whole_file(folder / ("corners" + suffix + ".vnl"), calibration_corners(report, camera));
    write_residual_image(report, camera, (folder / ("residuals" + suffix + ".png")).string());
    write_uncertainty_image(report, camera, (folder / ("uncertainty" + suffix + ".png")).string());
  }
  write_whole_file(folder / "opencv.yaml", opencv_calibration_text(cameras));
  if (has_kalibr_form(cameras)) {
    write_whole_file(folder / "camchain.yaml", kalibr_calibration_text(cameras));
  } else {
    std::error_code ignored;
    std::filesystem::remove(folder / "camchain.yaml", ignored);  // of a former calibration, with --force
  }
  write_whole_file(folder / "calibration.json", calibration_json(report));
}

/// The boards of the calibration with their depth.
DepthCalibrationInput depth_input(const CalibrateFlags& flags, const CalibrationReport& report,
                                  const std::vector<DepthImage>& depths) {
  DepthCalibrationInput input;
  const BoardProblem& problem = report.calibration.solution.problem;
  input.registered = flags.depth_camera.empty();
  input.depth_camera = input.registered ? camera_of(problem.lenses.front(), report.input.width, report.input.height)
                                        : read_calibration(flags.depth_camera).cameras.at(0).camera;
  for (const DepthImage& depth : depths) {
    if (input.depth_camera.width > 0 || depth.empty()) continue;
    input.depth_camera.width = depth.width();
    input.depth_camera.height = depth.height();
  }
  input.focal_length_sigma = report.calibration.lens_sigmas(0)[0] / problem.lenses.front().parameters[0];
  input.low = input.high = problem.board.front();
  for (const Eigen::Vector2d& point : problem.board) {
    input.low = input.low.cwiseMin(point);
    input.high = input.high.cwiseMax(point);
  }
  for (const BoardView& view : problem.views) {
    const auto frame = static_cast<std::size_t>(view.frame);
    if (!depths[frame].empty()) input.views.push_back({problem.left_from_board[frame], &depths[frame]});
  }
  return input;
}

void append_depth(const std::string& depth_text, const std::filesystem::path& path) {
  write_whole_file(path, read_text_file(path.string()) + depth_text);
}

/// What does not go together.
void check_flags(const CalibrateFlags& flags) {
  const bool live = is_live(flags.data.path);
  if (!flags.right.empty() && live != is_live(flags.right))
    throw Error(live ? "is a recording beside a live source" : "is a live source beside a recording", "--right",
                "give two of the same kind");
  if (flags.stereo && !flags.right.empty())
    throw Error("is for sources that have both images", "--stereo", "omit it, or --right");
  if (flags.depth && (flags.stereo || !flags.right.empty()))
    throw Error("is for one camera", "--depth", "omit --stereo and --right");
  if (!flags.depth && !flags.depth_camera.empty()) throw Error("is for --depth", "--depth-camera", "add --depth");
}

/// Null without --view.
std::unique_ptr<LiveBoards> live_page(const CalibrateFlags& flags) {
  const bool has_server = flags.server.port || !flags.server.listen.empty() || !flags.server.token.empty();
  if (!flags.view && has_server) throw Error("nothing is served", "--port, --listen, --token", "add --view");
  if (!flags.view) return nullptr;
  if (!is_live(flags.data.path)) throw Error("is for live sources", "--view", "give replay:DATA to see a recording");
  LiveHello hello;
  hello.title = scene_name(flags.out);
  hello.method = "calibrate";
  return std::make_unique<LiveBoards>(flags.server, hello, flags.stereo || !flags.right.empty() ? 2 : 1);
}

void require_task(const CalibrateFlags& flags) {
  if (flags.data.path.empty()) throw Error("is missing", "DATA", "give images, a video or a recording of a board");
  if (flags.board.empty())
    throw Error("is missing", "--board",
                "say what it shows: chessboard:9x6:0.025 (inner corners, side of a square); --help has the others");
}

BoardImages find_images(const CalibrateFlags& flags, const Board& board, LiveBoards* page) {
  const BoardSearchOptions search_for{flags.right, flags.most_views, flags.stereo, flags.depth,
                                      !flags.depth_camera.empty()};
  if (is_live(flags.data.path)) return find_boards_live(flags.data, board, search_for, page);
  ProgressBar bar(!flags.data.quiet);
  BoardImages found = find_boards(flags.data, board, search_for, bar);
  bar.clear();
  return found;
}

CalibrationReport report_of(const CalibrateFlags& flags, const CalibrationOptions& options, BoardImages found) {
  CalibrationReport report;
  report.calibration = calibrate_camera(found.input, options);
  report.input = std::move(found.input);
  report.images = found.images;
  report.found = found.found;
  report.readout_s = std::max(0.0, flags.data.readout_s);
  for (std::size_t camera = 0; camera < (report.input.stereo ? 2U : 1U); ++camera)
    report.trust.push_back(judge_calibration(report.calibration, camera, report.input.width, report.input.height));
  if (report.input.stereo) judge_baseline(report.calibration, flags.baseline_m, report.trust.back());
  if (flags.depth) report.depth = calibrate_depth(depth_input(flags, report, found.depths));
  return report;
}

void calibrate(const CalibrateFlags& flags) {
  require_task(flags);
  const Board board = parse_board(flags.board);
  if (board.square_m > largest_usual_square_m)
    log_warning(fmt::format("--board {}: squares of {:g} m? Sizes are in meters", flags.board, board.square_m));
  CalibrationOptions options;
  if (flags.model != "auto") options.model = model_named(flags.model);
  check_flags(flags);
  refuse_existing_output(flags);
  const OutputFolder out(flags.out);
  catch_interrupts();
  const std::unique_ptr<LiveBoards> page = live_page(flags);
  BoardImages found = find_images(flags, board, page.get());
  const DepthAsRead depth_as_read = found.depth_as_read;
  const CalibrationReport report = report_of(flags, options, std::move(found));
  write_files(report, board, flags.out);
  if (report.depth)
    append_depth(depth_calibration_text(*report.depth, depth_as_read),
                 std::filesystem::path(flags.out) / "camera.yaml");
  if (flags.data.json) {
    fmt::print("{}", calibration_json(report));
  } else if (!flags.data.quiet) {
    fmt::print("{}files written to {}\n", calibration_summary(report), flags.out);
  }
  if (!page) return;
  Trust worst = Trust::good;
  for (const CalibrationTrust& camera : report.trust) worst = std::max(worst, camera.trust);
  page->finish(fmt::format("calibrated from {} views: {}", report.input.frames.size(), trust_word(worst)));
  page->wait_until_closed();
}

void add_flags(CLI::App& command, CalibrateFlags& flags) {
  add_data_flags(command, flags.data);
  command.get_option("DATA")->required(false);
  command.add_option("--board", flags.board, "The board in the images; sizes in meters")
      ->type_name("KIND:COLUMNSxROWS:...");
  command.add_option("--out", flags.out, "Output folder; with --make-board the .svg or .pdf file")
      ->type_name("DIR")
      ->required();
  command
      .add_option("--right", flags.right,
                  "Images of the right camera of a pair, one for each of DATA, or a second live source")
      ->type_name("DATA");
  command.add_flag("--stereo", flags.stereo, "Both cameras of DATA, a recording or replay of a stereo pair");
  command
      .add_option("--baseline", flags.baseline_m,
                  "Known baseline of the pair in meters: checks the size of the squares, which images alone cannot")
      ->type_name("METERS")
      ->check(CLI::PositiveNumber);
  command
      .add_option(
          "--model", flags.model,
          "Lens model: auto, pinhole4 (k1 k2 p1 p2), pinhole5 (with k3), pinhole8 (rational, k4 k5 k6), equidistant")
      ->type_name("MODEL")
      ->capture_default_str();
  command.add_flag("--depth", flags.depth,
                   "Also scale, offset and noise of the depth, and whether it is registered to the image");
  command
      .add_option("--depth-camera", flags.depth_camera,
                  "Calibration of a depth camera whose depth is not registered to the image")
      ->type_name("FILE");
  command.add_option("--most-views", flags.most_views, "Views of the board to use at most, evenly chosen")
      ->type_name("N")
      ->check(CLI::Range(3, 1000))
      ->capture_default_str();
  command.add_option("--make-board", flags.make_board, "Writes a board to print instead of calibrating")
      ->type_name("KIND:COLUMNSxROWS:...");
  command.add_flag("--force", flags.force, "Overwrite --out");
  command.add_flag("--view", flags.view,
                   "Shows a live calibration in a browser: the image, the corners, and where to hold the board next");
  add_server_flags(command, flags.server, "Viewer");
}

}  // namespace

void add_calibrate_command(CLI::App& app, Context& context) {
  CLI::App* command = app.add_subcommand("calibrate", "Calibrates a camera or a pair from images of a board");
  const auto flags = std::make_shared<CalibrateFlags>();
  add_flags(*command, *flags);
  command->footer(calibrate_footer);
  command->callback([flags, &context] {
    if (flags->data.quiet) set_log_sink({});
    if (!flags->make_board.empty()) {
      make_board(*flags);
    } else {
      try {
        calibrate(*flags);
      } catch (const Interrupted&) {
        if (!flags->data.quiet) fmt::print("interrupted: nothing was written\n");
      }
    }
    context.exit_code = done;
  });
}

}  // namespace rastro::cli
