// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <tuple>
#include <vector>

#include "rastro/base/error.h"
#include "rastro/base/log.h"
#include "rastro/base/output_path.h"
#include "rastro/base/text.h"
#include "rastro/base/text_file.h"
#include "rastro/cli/command.h"
#include "rastro/cli/export_input.h"
#include "rastro/cli/lengths_scale.h"
#include "rastro/cli/limits.h"
#include "rastro/cli/map_path.h"
#include "rastro/cli/recorded_images.h"
#include "rastro/cli/recording_of_run.h"
#include "rastro/evaluate/length_report.h"
#include "rastro/evaluate/trajectory_input.h"
#include "rastro/evaluate/trajectory_pairs.h"
#include "rastro/export/length_image.h"
#include "rastro/export/ply.h"
#include "rastro/map/file/map_file.h"
#include "rastro/map/images/pack_images.h"
#include "rastro/map/landmarks/map_scale.h"
#include "rastro/math/alignment.h"

namespace rastro::cli {
namespace {

namespace fs = std::filesystem;

constexpr const char* measure_footer =
    R"(MAP is a map file (map.rastro), a run folder, or a point cloud (.ply, in meters; its sigma is used if present). In a map,
planes are fitted to the depth images of the keyframes and edges are found with subpixel precision in their color images;
every keyframe that observes both ends measures the length by itself, keyframes that observe one end count with the
uncertainty of their poses. A map without images (orb, lsd) is measured in those of the recording that it was made of, or
that of --images. In a map without depth edges are triangulated: keyframes must see them from several sides, and planes
and points without edges are not measured. In a cloud an edge is where the points end, and sigmas are larger.

The map of one camera has an arbitrary unit, and so have its points. --known takes the object of FILE that sets the scale by
its length_m; it is left out of the result. A map that is metric already is scaled by it as well.

FILE (YAML, meters):
  frame: first_camera        # world of the map (default); or `truth`: frame of the trajectory given with --align
  radius_m: 0.06             # maximum error of a given point (default: 0.06); may be set per object
  objects:
    - name: box width
      length_m: 0.32         # true length, if known
      kind: edges            # two parallel straight edges, measured perpendicular to both
      a: {point: [-0.16, 0.2, 2.0], direction: [0, 1, 0]}   # approximate center and direction of the edge
      b: {point: [0.16, 0.2, 2.0], direction: [0, 1, 0]}    # face: [x, y, z]: a point on the plane that the edge bounds
                                                            # (default: halfway between a and b)
    - name: room width
      kind: planes           # two parallel planes
      a: {point: [-1.5, 0, 2], normal: [1, 0, 0]}           # normal: approximate, either sign; may be omitted
      b: {point: [1.7, 0, 2], normal: [1, 0, 0]}
    - name: diagonal
      kind: points           # two surface points, or corners where two edges intersect
      a: {point: [-0.16, 0.1, 2.0], edges: [[1, 0, 0], [0, 1, 0]], face: [0, 0.2, 2.0]}
      b: {point: [0.16, 0.3, 2.0], edges: [[1, 0, 0], [0, 1, 0]], face: [0, 0.2, 2.0]}

sigma is one standard deviation: of images, depth and poses, and of confusing an edge with another. A length that cannot be
measured is reported with the reason, a doubtful one with a note. Several maps (of one recording) give a table of mean
lengths, mean and maximum error, and error / sigma (about 1 if the sigmas are consistent).

--require takes measured (share of all), mean_error_m, max_error_m, max_error_percent, max_sigma_m, rms_sigmas.

Examples:
  rastro measure run --objects bedroom/objects.yaml
  rastro measure seed*/map.rastro --objects study/objects.yaml --csv > lengths.csv
  rastro measure run --objects objects.yaml --only 'box width' --require 'max_error_m<=0.01' --out images
  rastro measure run --objects objects.yaml --known 'box width'
  rastro measure run/map.rastro --between -0.5,0.2,2.1 0.4,0.2,2.1)";

struct MeasureFlags {
  std::vector<std::string> maps, between, only, limits;
  std::string objects, align, images, known, out;
  int threads = 0;
  std::uint64_t seed = 1;
  bool json = false, csv = false, quiet = false;
};

struct OpenedMap {
  std::shared_ptr<const Map> map;  ///< With images; null: there is only a cloud.
  PointCloud cloud;
};

std::shared_ptr<const Map> load_map_with_images(const fs::path& file, const std::string& recording) {
  auto map = load_map(file);
  if (map->layer<ImageLayer>()) return map;
  const auto images = recordings_of_map(*map, file, recording);
  if (!any_found(images)) refuse_without_layer(file.string(), ImageLayer::layer_name, "a length");
  return with_recorded_images(*map, images);
}

OpenedMap open_map(const std::string& path, const std::string& recording) {
  const fs::path file = map_file_of(path);
  std::error_code ignored;
  if (file.extension() == ".ply") return {nullptr, read_cloud_ply(file.string())};
  if (fs::is_directory(path, ignored) && !fs::exists(file, ignored)) {
    const fs::path cloud = fs::path(path) / "cloud.ply";
    if (!fs::exists(cloud, ignored))
      throw Error("has neither map.rastro nor cloud.ply", path, "give the run of a depth camera");
    return {nullptr, read_cloud_ply(cloud.string())};
  }
  return {load_map_with_images(file, recording), {}};
}

/// ground_truth_from_map, from poses of equal timestamps. A map of arbitrary scale is made metric.
SE3 aligned(OpenedMap& map, const std::string& path, const std::string& ground_truth_file_name) {
  if (!map.map) throw Error("has no trajectory to align", path, "give a map file or a run folder");
  const TrajectoryInput ground_truth = read_trajectory_input(ground_truth_file_name);
  const auto session = session_of_reference(*map.map, map_file_of(path), ground_truth_file_name);
  if (!scale_of(*map.map).metric)
    map.map = std::make_shared<const Map>(
        scaled(*map.map, scale_from_reference(*map.map, ground_truth.poses, ground_truth_file_name, session)));
  constexpr TimeNs max_difference = 20'000'000;
  std::vector<Eigen::Vector3d> target, source;
  const Trajectory trajectory = trajectory_for_reference(*map.map, session, ground_truth_file_name);
  for (const PosePair& pair : pair_by_stamp(ground_truth.poses, trajectory, max_difference)) {
    target.push_back(ground_truth.poses[pair.reference].world_from_body.translation());
    source.push_back(trajectory[pair.estimate].world_from_body.translation());
  }
  const auto alignment = align_points(target, source, AlignmentKind::rigid);
  if (!alignment || !alignment->unique)
    throw Error(
        fmt::format("{} poses match a timestamp of {}: too few, or all on one line", target.size(), one_line(path)),
        ground_truth_file_name, "is it of the same recording?");
  return {alignment->target_from_source.rotation(), alignment->target_from_source.translation()};
}

Eigen::Vector3d point_in(const std::string& text) {
  const auto pieces = split(text, ',');
  Eigen::Vector3d point;
  for (int k = 0; k < 3; ++k) {
    const auto number = pieces.size() == 3 ? parse_finite(pieces[static_cast<std::size_t>(k)]) : std::nullopt;
    if (!number || std::abs(*number) > 1e4)
      throw Error(in_quotes(text) + " is not a point", "--between", "give x,y,z in meters, such as 0.5,-0.2,2.1");
    point[k] = *number;
  }
  return point;
}

/// The known length must be one of the objects.
void check_known(const LengthObjects& objects, const std::string& known) {
  if (known.empty()) return;
  std::vector<std::string> names;
  for (const LengthObject& object : objects.objects)
    if (object.true_length_m) names.push_back(object.name);
  if (std::find(names.begin(), names.end(), known) == names.end())
    throw Error(in_quotes(known) + " is no object with a length_m", "--known", did_you_mean(known, names));
}

LengthObjects objects_of(const MeasureFlags& flags) {
  if (flags.objects.empty() == flags.between.empty())
    throw Error("needs lengths to measure", "rastro measure", "give --objects FILE or --between x,y,z x,y,z");
  if (!flags.between.empty()) {
    LengthObject object;
    object.name = "between";
    object.kind = LengthKind::points;
    object.a.point = point_in(flags.between[0]);
    object.b.point = point_in(flags.between[1]);
    check_known({false, {}}, flags.known);
    if ((object.a.point - object.b.point).norm() < 1e-3)
      throw Error("the two points are the same", "--between", "give two different ones");
    return {false, {object}};
  }
  LengthObjects all = parse_length_objects(read_text_file(flags.objects), flags.objects);
  std::vector<std::string> names;
  for (const LengthObject& object : all.objects) names.push_back(object.name);
  for (const std::string& name : flags.only) {
    if (std::find(names.begin(), names.end(), name) != names.end()) continue;
    throw Error(fmt::format("{} is not an object of {}", in_quotes(name), one_line(flags.objects)), "--only",
                did_you_mean(name, names));
  }
  check_known(all, flags.known);
  std::erase_if(all.objects, [&](const LengthObject& object) {
    return !flags.only.empty() && object.name != flags.known &&
           std::find(flags.only.begin(), flags.only.end(), object.name) == flags.only.end();
  });
  return all;
}

std::string file_name_of(const std::string& name) {
  std::string safe;
  for (const char letter : name) safe += std::isalnum(static_cast<unsigned char>(letter)) != 0 ? letter : '_';
  return safe;
}

/// An image for each length that was measured in images: OUT/mapN_K_NAME.png.
void write_images(const fs::path& folder, std::size_t number, const Map& map,
                  const std::vector<MeasuredLength>& lengths) {
  const auto images = images_of(map);
  for (std::size_t k = 0; k < lengths.size(); ++k) {
    const MeasuredLength& one = lengths[k];
    if (one.image.keyframe < 0 || !one.length_m) continue;
    const std::string where = fmt::format("keyframe {}", one.image.keyframe);
    const auto keyframe_images = unpack_images(images->read(one.image.keyframe), where);
    const std::string file = fmt::format("map{}_{}_{}.png", number + 1, k + 1, file_name_of(one.name));
    write_length_image(keyframe_images.color, {one.image.a, one.image.b},
                       fmt::format("{}: {:.4f} m +- {:.4f}", one.name, *one.length_m, one.sigma_m),
                       (folder / file).string());
  }
}

int measure(const MeasureFlags& flags) {
  if (flags.json && flags.csv) throw Error("cannot be given together", "--json and --csv", "choose one");
  const std::vector<ScoreLimit> limits = parse_limits(flags.limits, length_figures({}), "'max_error_m<=0.01'");
  const LengthObjects wanted = objects_of(flags);
  if (wanted.in_frame_of_ground_truth && flags.align.empty())
    throw Error("gives its points in the frame of the ground truth", flags.objects,
                "add --align FILE, the ground-truth trajectory");
  if (!wanted.in_frame_of_ground_truth && !flags.align.empty())
    throw Error("is unused: the points are given in the frame of the map", "--align",
                "omit it, or set 'frame:' in the file of --objects");
  std::optional<OutputFolder> out;
  if (!flags.out.empty()) out.emplace(flags.out);
  TaskPool pool(flags.threads);
  MapLengthOptions options;
  options.seed = flags.seed;
  std::vector<MapOfLengths> results;
  for (const std::string& path : flags.maps) {
    OpenedMap map = open_map(path, flags.images);
    std::vector<LengthObject> objects = wanted.objects;
    if (wanted.in_frame_of_ground_truth) {
      const SE3 map_from_ground_truth = aligned(map, path, flags.align).inverse();
      for (LengthObject& object : objects) object = moved(object, map_from_ground_truth);
    }
    if (map.map) std::tie(map.map, objects) = roughly_metric(map.map, std::move(objects), flags.known, path);
    results.push_back({path, map.map ? measure_lengths(*map.map, objects, options, pool)
                                     : measure_lengths(map.cloud, objects, options)});
    if (!flags.out.empty() && map.map) write_images(flags.out, results.size() - 1, *map.map, results.back().lengths);
    apply_known_length(results.back().lengths, flags.known);
  }
  if (flags.json)
    fmt::print("{}", lengths_as_json(results));
  else if (flags.csv)
    fmt::print("{}", lengths_as_csv(results));
  else if (!flags.quiet)
    fmt::print("{}", lengths_as_text(results));
  return report_missed(limits, length_figures(results));
}

void check_threads(int threads) {
  if (threads < 0 || threads > 1024)
    throw Error(fmt::format("{} is not a number of threads", threads), "--threads", "give 0 to 1024");
}

}  // namespace

void add_measure_command(CLI::App& app, Context& context) {
  CLI::App* command =
      app.add_subcommand("measure", "Measures lengths in maps and point clouds, with their uncertainty");
  const auto flags = std::make_shared<MeasureFlags>();
  command->add_option("MAP", flags->maps, "Map files, run folders or point clouds (.ply)")->type_name("")->required();
  command->add_option("--objects", flags->objects, "YAML file of the lengths to measure, see below")->type_name("FILE");
  command
      ->add_option("--between", flags->between,
                   "One length: between the surface points nearest to two points x,y,z, in meters")
      ->type_name("POINT")
      ->expected(2);
  command->add_option("--only", flags->only, "Only the length of this name; may be repeated")
      ->type_name("NAME")
      ->allow_extra_args(false);
  command->add_option("--align", flags->align, "Ground-truth trajectory, for points given in its frame")
      ->type_name("FILE");
  command
      ->add_option("--images", flags->images,
                   "Recording with the images of a map that has none (default: the recording that the map was made of)")
      ->type_name("DATA");
  command
      ->add_option("--known", flags->known,
                   "Object whose length_m sets the scale, for maps of one camera; left out of the result")
      ->type_name("NAME");
  command->add_option("--out", flags->out, "Folder for an image of each length with the measured edges")
      ->type_name("DIR");
  command
      ->add_option("--require", flags->limits,
                   "Limit, such as 'max_error_m<=0.01'; exit code 1 if missed; may be repeated")
      ->type_name("LIMIT")
      ->allow_extra_args(false);
  command->add_option("--seed", flags->seed, "Seed of the random numbers (default: 1)")->type_name("N");
  command
      ->add_option("--threads", flags->threads,
                   "Number of threads; the results do not depend on it (default: all cores)")
      ->type_name("N");
  command->add_flag("--json", flags->json, "Print the result as JSON");
  command->add_flag("--csv", flags->csv, "Print the result as CSV, a line per length");
  command->add_flag("--quiet", flags->quiet, "Print errors and warnings only");
  command->footer(measure_footer);
  command->callback([flags, &context] {
    if (flags->quiet) set_log_sink({});
    check_threads(flags->threads);
    context.exit_code = measure(*flags);
  });
}

}  // namespace rastro::cli
