// SPDX-License-Identifier: Apache-2.0
#include "rastro/dataset/tum_rgbd/tum_rgbd.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>

#include "rastro/base/error.h"
#include "rastro/base/text.h"
#include "rastro/base/text_file.h"
#include "rastro/dataset/calibration.h"
#include "rastro/dataset/folder.h"
#include "rastro/dataset/ground_truth.h"
#include "rastro/dataset/tum_rgbd/depth_factor.h"
#include "rastro/dataset/tum_rgbd/published_intrinsics.h"
#include "rastro/sensor/trajectory_file.h"

namespace rastro {
namespace {

namespace fs = std::filesystem;

constexpr TimeNs max_depth_difference = 20'000'000;  // associate.py of the TUM benchmark.

fs::path associations_file(const fs::path& folder) {
  for (const char* name : {"associations.txt", "associate.txt", "association.txt", "rgbd_assoc.txt"}) {
    if (is_file(folder / name)) return folder / name;
  }
  return {};
}

/// The images of the recording, and the depth image of each where there is one (index into depth, -1 = none).
struct Lists {
  ImageList color;
  ImageList depth;
  std::vector<std::int64_t> partner;
  std::string paired_by = "within 0.02 s";
  std::string warning;  ///< Empty: none.

  std::size_t pairs() const {
    return static_cast<std::size_t>(std::count_if(partner.begin(), partner.end(), [](auto row) { return row >= 0; }));
  }
};

/// "./rgb/1.png" and "rgb/1.png" are one file.
std::string normal_name(const std::string& file) { return fs::path(file).lexically_normal().generic_string(); }

void pair_as_listed(Lists& lists, const TumAssociations& associations, const fs::path& file) {
  std::map<std::string, std::size_t> row_of;
  for (std::size_t k = 0; k < associations.color.images.size(); ++k)
    row_of.emplace(normal_name(associations.color.images[k].file), k);
  lists.depth = associations.depth;
  lists.paired_by = "in " + file.filename().string();
  lists.partner.clear();
  for (const auto& image : lists.color.images) {
    const auto row = row_of.find(normal_name(image.file));
    lists.partner.push_back(row == row_of.end() ? -1 : static_cast<std::int64_t>(row->second));
  }
}

void pair_by_stamps(Lists& lists, const fs::path& file) {
  lists.depth = parse_tum_image_list(read_text_file(file.string()), file.string());
  lists.partner = associate(lists.color.images, lists.depth.images, max_depth_difference);
  lists.paired_by = "within 0.02 s";
}

Lists read_lists(const fs::path& folder) {
  Lists lists;
  const fs::path color = folder / "rgb.txt", depth = folder / "depth.txt", pairs = associations_file(folder);
  std::optional<TumAssociations> associations;
  if (!pairs.empty()) associations = parse_tum_associations(read_text_file(pairs.string()), pairs.string());
  lists.color =
      is_file(color) ? parse_tum_image_list(read_text_file(color.string()), color.string()) : associations->color;
  lists.partner.assign(lists.color.images.size(), -1);
  if (associations) pair_as_listed(lists, *associations, pairs);
  if (lists.pairs() > 0 || !is_file(depth)) return lists;
  if (associations)
    lists.warning = fmt::format("{}: names none of the images of rgb.txt; depth.txt is used", pairs.string());
  pair_by_stamps(lists, depth);
  return lists;
}

void fill_frames(Recording& recording, const Lists& lists, const fs::path& folder) {
  for (std::size_t k = 0; k < lists.color.images.size(); ++k) {
    const auto& image = lists.color.images[k];
    RecordedFrame frame{image.stamp, (folder / image.file).string(), "", "", 0};
    if (lists.partner[k] >= 0) {
      const auto& depth = lists.depth.images[static_cast<std::size_t>(lists.partner[k])];
      frame.depth = (folder / depth.file).string();
      frame.depth_stamp = depth.stamp;
    }
    recording.frames.push_back(std::move(frame));
  }
  const std::size_t pairs = lists.pairs();
  recording.info.has_depth = pairs > 0;
  if (!lists.warning.empty()) recording.info.warnings.push_back(lists.warning);
  if (!lists.depth.images.empty() && pairs < recording.frames.size()) {
    recording.info.warnings.push_back(
        fmt::format("{} of {} color images have a depth image {}", pairs, recording.frames.size(), lists.paired_by));
  }
}

void set_depth_factor(Recording& recording, const fs::path& folder, bool published, const std::string& given) {
  if (!recording.info.has_depth) return;
  // Of the given file, else of the folder's own files, else what the benchmark publishes.
  auto known = given.empty() ? std::nullopt : read_depth_factor(given);
  if (!known) known = depth_factor_in(folder);
  if (!known && published) known = DepthFactor{5000.0, "TUM's", false, 0.0};
  std::vector<std::string> files;
  for (const auto& frame : recording.frames)
    if (!frame.depth.empty()) files.push_back(frame.depth);
  const auto factor = known ? *known : guess_depth_factor_of(files);
  recording.info.depth_factor = factor.units_per_meter;
  recording.info.depth_offset_m = factor.offset_m;
  if (factor.is_a_guess) {
    recording.info.warnings.push_back(fmt::format("depth is assumed to have {:g} units per meter, because {}",
                                                  factor.units_per_meter, factor.reason));
  }
}

/// Returns whether the folder is one of the benchmark's own.
bool add_camera(SourceInfo& info, const fs::path& path, bool given) {
  const auto published = tum_camera_of_folder(path);
  const auto file = given ? fs::path() : find_calibration_file(path);
  if (!file.empty()) {
    read_cameras(info, file, {"rgb"});
  } else {
    info.cameras.push_back(published ? *published : uncalibrated("rgb"));
  }
  return published.has_value();
}

void require_main_camera(const std::string& wanted, const fs::path& path) {
  if (!wanted.empty() && wanted != "rgb")
    throw Error(fmt::format("there is no camera '{}'", wanted), path.string(), "there is rgb");
}

}  // namespace

ImageList parse_tum_image_list(std::string_view text, std::string_view where) {
  std::vector<RawListLine> lines;
  for (const auto& line : content_lines(text)) {
    const auto words = split_words(line.text);
    if (words.size() != 2) {
      throw Error(fmt::format("{} columns instead of the 2 of 'stamp file'", words.size()), at_line(where, line.number),
                  "");
    }
    lines.push_back({line.number, words[0], words[1]});
  }
  return make_image_list(lines, StampUnit::seconds, where);
}

TumAssociations parse_tum_associations(std::string_view text, std::string_view where) {
  std::vector<RawListLine> first, second;
  for (const auto& line : content_lines(text)) {
    const auto words = split_words(line.text);
    if (words.size() != 4) {
      throw Error(fmt::format("{} columns instead of the 4 of 'stamp file stamp file'", words.size()),
                  at_line(where, line.number), "");
    }
    first.push_back({line.number, words[0], words[1]});
    second.push_back({line.number, words[2], words[3]});
  }
  TumAssociations associations{make_image_list(first, StampUnit::seconds, where),
                               make_image_list(second, StampUnit::seconds, where)};
  if (associations.color.images.front().file.starts_with("depth")) std::swap(associations.color, associations.depth);
  return associations;
}

std::optional<Recording> index_tum_rgbd(const fs::path& path, const OpenOptions& options) {
  if (!is_file(path / "rgb.txt") && associations_file(path).empty()) return std::nullopt;
  require_main_camera(options.camera, path);
  Recording recording;
  recording.info.path = path.string();
  recording.info.format = "tum_rgbd";
  const auto lists = read_lists(path);
  if (auto warning = unit_warning(lists.color.unit, StampUnit::seconds, path.string()); !warning.empty()) {
    recording.info.warnings.push_back(warning);
  }
  recording.stamp_unit = unit_name(lists.color.unit);
  fill_frames(recording, lists, path);

  const bool published = add_camera(recording.info, path, calibration_is_given(options));
  set_depth_factor(recording, path, published, options.calibration_file);

  const fs::path ground_truth = path / "groundtruth.txt";
  if (is_file(ground_truth)) {
    read_ground_truth(recording.info, ground_truth, "camera", [&] {
      const std::string text = read_text_file(ground_truth.string());
      return parse_tum_trajectory(text, ground_truth.string(), guess_column_unit(text, StampUnit::seconds));
    });
  }
  return recording;
}

}  // namespace rastro
