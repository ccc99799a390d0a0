// SPDX-License-Identifier: Apache-2.0
// Times rastro's tracker against plain OpenCV (goodFeaturesToTrack + calcOpticalFlowPyrLK forward and backward) on the
// same frames in the same run:  rastro_bench_track DATA [--features N] [--threads N] [--mode M] [--repeats N] [--frames
// N] [--set key=value]...
#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <ctime>
#include <numeric>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <opencv2/video/tracking.hpp>
#include <string>
#include <vector>

#include "rastro/base/text.h"
#include "rastro/dataset/open.h"
#include "rastro/math/median.h"
#include "rastro/track/tracker.h"

namespace {

using namespace rastro;

/// Wall time, or with one thread the thread's own processor time, which a busy machine does not affect.
double now_ms(int threads) {
  if (threads > 1)
    return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now().time_since_epoch()).count();
  timespec time{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
  return static_cast<double>(time.tv_sec) * 1e3 + static_cast<double>(time.tv_nsec) * 1e-6;
}

/// A front end like that of VINS-Fusion, with OpenCV's functions alone.
class PlainOpenCv {
 public:
  PlainOpenCv(int features, double min_distance) : features_(features), min_distance_(min_distance) {}

  void process(const cv::Mat& image) {
    if (!points_.empty()) follow(image);
    const int missing = features_ - static_cast<int>(points_.size());
    if (missing > 0) detect(image, missing);
    previous_ = image;
  }

 private:
  void follow(const cv::Mat& image) {
    std::vector<cv::Point2f> forward, backward;
    std::vector<unsigned char> found, found_back;
    std::vector<float> error;
    const cv::Size window(21, 21);
    cv::calcOpticalFlowPyrLK(previous_, image, points_, forward, found, error, window, 3);
    cv::calcOpticalFlowPyrLK(image, previous_, forward, backward, found_back, error, window, 3);
    std::vector<cv::Point2f> kept;
    for (std::size_t i = 0; i < forward.size(); ++i) {
      const bool inside = forward[i].x >= 0 && forward[i].y >= 0 && forward[i].x < static_cast<float>(image.cols) &&
                          forward[i].y < static_cast<float>(image.rows);
      if (found[i] && found_back[i] && inside && cv::norm(backward[i] - points_[i]) <= 0.5) kept.push_back(forward[i]);
    }
    points_ = kept;
  }

  void detect(const cv::Mat& image, int missing) {
    cv::Mat mask(image.size(), CV_8U, cv::Scalar(255));
    for (const auto& point : points_) cv::circle(mask, point, static_cast<int>(min_distance_), 0, -1);
    std::vector<cv::Point2f> corners;
    cv::goodFeaturesToTrack(image, corners, missing, 0.01, min_distance_, mask);
    points_.insert(points_.end(), corners.begin(), corners.end());
  }

  int features_;
  double min_distance_;
  cv::Mat previous_;
  std::vector<cv::Point2f> points_;
};

struct Arguments {
  std::string data;
  int threads = 1;
  int repeats = 5;
  int frames = 1'000'000;
  TrackOptions options;
};

Arguments read_arguments(int argc, char** argv) {
  Arguments arguments;
  OptionTable table = option_table(arguments.options);
  for (int i = 1; i < argc; ++i) {
    const std::string flag = argv[i];
    const std::string value = i + 1 < argc ? argv[i + 1] : "";
    const auto number = [&] { return static_cast<int>(parse_int64(value).value_or(1)); };
    if (!flag.starts_with("--")) {
      arguments.data = flag;
      continue;
    }
    ++i;
    if (flag == "--threads")
      arguments.threads = number();
    else if (flag == "--repeats")
      arguments.repeats = number();
    else if (flag == "--frames")
      arguments.frames = number();
    else if (flag == "--set")
      table.set_assignment(value, "--set");
    else
      table.set(flag.substr(2), value, flag);
  }
  if (arguments.data.empty()) throw Error("no data given", "rastro_bench_track", "give a recording");
  return arguments;
}

/// Times and results of all frames of all repeats.
struct Sums {
  TrackTimes times;
  std::int64_t tracked = 0, reidentified = 0, corners = 0;
  std::vector<double> ratios, ours_ms, theirs_ms;  ///< One per repeat; milliseconds per frame.

  void add(const TrackFrame& frame) {
    const TrackTimes& t = frame.times;
    times.pyramid_ms += t.pyramid_ms;
    times.flow_ms += t.flow_ms;
    times.outlier_ms += t.outlier_ms;
    times.predict_ms += t.predict_ms;
    times.detect_ms += t.detect_ms;
    times.describe_ms += t.describe_ms;
    times.match_ms += t.match_ms;
    times.validate_ms += t.validate_ms;
    times.total_ms += t.total_ms;
    tracked += frame.tracked;
    reidentified += frame.reidentified;
    corners += frame.fresh + frame.reidentified;
  }
};

void print(const Sums& sums, double calls) {
  fmt::print(
      "rastro  {:.3f} ms per frame (median)\nOpenCV  {:.3f} ms per frame (median)\nratio   {:.3f} (min {:.3f}, max "
      "{:.3f})\n",
      upper_median(sums.ours_ms), upper_median(sums.theirs_ms), upper_median(sums.ratios),
      *std::min_element(sums.ratios.begin(), sums.ratios.end()),
      *std::max_element(sums.ratios.begin(), sums.ratios.end()));
  const TrackTimes& t = sums.times;
  fmt::print(
      "stages  pyramid {:.3f}, flow {:.3f}, outliers {:.3f}, predict {:.3f}, detect {:.3f}, describe {:.3f}, match "
      "{:.3f}, validate {:.3f} ms\n",
      t.pyramid_ms / calls, t.flow_ms / calls, t.outlier_ms / calls, t.predict_ms / calls, t.detect_ms / calls,
      t.describe_ms / calls, t.match_ms / calls, t.validate_ms / calls);
  fmt::print("tracked {:.1f} per frame, re-identified {:.2f} of {:.2f} corners\n",
             static_cast<double>(sums.tracked) / calls, static_cast<double>(sums.reidentified) / calls,
             static_cast<double>(sums.corners) / calls);
}

void run(const Arguments& arguments) {
  OpenOptions open_options;
  open_options.end_frame = arguments.frames;
  const auto source = open(arguments.data, open_options);
  std::vector<GrayImage> images;
  while (auto frame = source->next()) images.push_back(std::move(frame->image));
  std::vector<cv::Mat> mats;
  for (GrayImage& image : images) {
    mats.emplace_back(image.height(), image.width(), CV_8U, image.row(0), static_cast<std::size_t>(image.stride()));
  }
  cv::setNumThreads(arguments.threads);
  TaskPool pool(arguments.threads);

  Sums sums;
  for (int repeat = 0; repeat < arguments.repeats; ++repeat) {
    Tracker tracker(arguments.options, source->info().cameras.front().camera, arguments.threads > 1 ? &pool : nullptr);
    PlainOpenCv opencv(arguments.options.features, arguments.options.min_distance_px);
    double ours = 0, theirs = 0;
    for (std::size_t i = 0; i < images.size(); ++i) {
      const double begin = now_ms(arguments.threads);
      const TrackFrame frame = tracker.process(images[i].view(), static_cast<TimeNs>(i));
      const double middle = now_ms(arguments.threads);
      opencv.process(mats[i]);
      theirs += now_ms(arguments.threads) - middle;
      ours += middle - begin;
      sums.add(frame);
    }
    sums.ours_ms.push_back(ours / static_cast<double>(images.size()));
    sums.theirs_ms.push_back(theirs / static_cast<double>(images.size()));
    sums.ratios.push_back(ours / theirs);
  }
  fmt::print("{} frames {}x{}, {} features, mode {}, {} thread(s), {} repeats\n", images.size(), mats[0].cols,
             mats[0].rows, arguments.options.features, arguments.options.mode, arguments.threads, arguments.repeats);
  print(sums, static_cast<double>(images.size()) * arguments.repeats);
}

}  // namespace

int main(int argc, char** argv) {
  try {
    run(read_arguments(argc, argv));
  } catch (const rastro::Error& error) {
    std::fprintf(stderr, "rastro_bench_track: %s\n", error.what());
    return 2;
  }
  return 0;
}
