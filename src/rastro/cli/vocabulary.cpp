// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>

#include "rastro/base/error.h"
#include "rastro/base/log.h"
#include "rastro/base/output_path.h"
#include "rastro/base/task_pool.h"
#include "rastro/cli/command.h"
#include "rastro/cli/progress_bar.h"
#include "rastro/dataset/open.h"
#include "rastro/feature/orb.h"
#include "rastro/place/vocabulary.h"

namespace rastro::cli {
namespace {

constexpr const char* vocabulary_footer =
    R"(Trains a bag-of-words vocabulary: a tree of ORB descriptors, by hierarchical clustering. The one that SLAM uses is built in
and was trained on many kinds of generated images. Your own helps where all recordings are of one kind, such as under water:
replace data/vocabulary.rvoc by it and build rastro again. IMAGES are folders or quoted globs of images, recordings or
videos, as DATA of other commands. Varied images are better than many of one place: use --every with recordings. The same
images and flags give the same bytes, for any number of threads.

Examples:
  rastro vocabulary images/ --out mine.rvoc
  rastro vocabulary MH_01_easy kitti/00 --every 10 --out mine.rvoc
  rastro vocabulary 'frames/*.png' --branching 10 --depth 4 --out small.rvoc)";

struct VocabularyFlags {
  std::vector<std::string> images;
  std::string out;
  int every = 1, threads = 0;
  OrbOptions features;
  VocabularyOptions tree;
  bool force = false, json = false, quiet = false;
};

using Descriptors = std::vector<std::vector<Descriptor>>;

/// Of every image of one argument. An image that cannot be read is skipped with a warning.
void collect(const std::string& path, const VocabularyFlags& flags, OrbExtractor& extractor, TaskPool& pool,
             ProgressBar& bar, Descriptors& descriptors) {
  OpenOptions options;
  options.every = flags.every;
  const std::unique_ptr<Source> source = rastro::open(path, options);
  if (!source->info().has_image) throw Error("has no images", path, "give recordings of a camera");
  const auto all = static_cast<std::size_t>(std::max<std::int64_t>(0, source->info().frame_count));
  for (std::size_t read = 0;; ++read) {
    try {
      const auto frame = source->next();
      if (!frame) return;
      descriptors.push_back(extractor.extract(frame->image.view(), {}, &pool).descriptors);
    } catch (const UnusableSource&) {
      throw;
    } catch (const Error& error) {
      log_warning(error.what());
    }
    bar.show_steps("images", read + 1, std::max(all, read + 1));
  }
}

void say(const VocabularyFlags& flags, const Descriptors& descriptors, const Vocabulary& vocabulary) {
  std::size_t count = 0;
  for (const auto& image : descriptors) count += image.size();
  std::error_code ignored;
  const bool is_file = std::filesystem::is_regular_file(flags.out, ignored);  // not /dev/stdout
  const auto bytes = is_file ? std::filesystem::file_size(flags.out, ignored) : 0;
  if (flags.json) {
    nlohmann::ordered_json json;
    json["out"] = flags.out;
    json["pictures"] = descriptors.size();
    json["descriptors"] = count;
    json["words"] = vocabulary.words();
    json["branching"] = vocabulary.branching();
    json["depth"] = vocabulary.depth();
    json["bytes"] = bytes;
    fmt::print("{}\n", json.dump(2, ' ', false, nlohmann::json::error_handler_t::replace));
  } else if (!flags.quiet) {
    fmt::print("{} words from {} descriptors of {} images written to {} ({:.0f} kB)\n", vocabulary.words(), count,
               descriptors.size(), flags.out, static_cast<double>(bytes) / 1e3);
  }
}

void train(const VocabularyFlags& flags) {
  refuse_existing(flags.out, flags.force);
  TaskPool pool(flags.threads);
  ProgressBar bar(!flags.quiet);
  OrbExtractor extractor(flags.features);
  Descriptors descriptors;
  for (const std::string& path : flags.images) collect(path, flags, extractor, pool, bar, descriptors);
  const auto vocabulary = Vocabulary::train(descriptors, flags.tree, &pool, [&](double share) {
    bar.show_steps("levels", static_cast<std::size_t>(share * flags.tree.depth + 0.5),
                   static_cast<std::size_t>(flags.tree.depth));
  });
  bar.clear();
  vocabulary.write(flags.out);
  say(flags, descriptors, vocabulary);
}

void add_flags(CLI::App& command, VocabularyFlags& flags) {
  command.add_option("IMAGES", flags.images, "Folders or globs of images, recordings, videos")
      ->type_name("")
      ->required();
  command.add_option("--out", flags.out, "Output file, .rvoc by convention")->type_name("FILE")->required();
  command.add_option("--every", flags.every, "Use every N-th image of each recording only")
      ->type_name("N")
      ->check(CLI::PositiveNumber)
      ->capture_default_str();
  command.add_option("--branching", flags.tree.branching, "Branching factor of the tree, 2 to 64")
      ->type_name("N")
      ->capture_default_str();
  command.add_option("--depth", flags.tree.depth, "Levels of the tree, 1 to 8; at most branching^depth words")
      ->type_name("N")
      ->capture_default_str();
  command.add_option("--features", flags.features.features, "ORB features per image")
      ->type_name("N")
      ->capture_default_str();
  command.add_option("--levels", flags.features.levels, "Levels of the image pyramid")
      ->type_name("N")
      ->capture_default_str();
  command.add_option("--scale-factor", flags.features.scale_factor, "Scale factor between pyramid levels")
      ->type_name("FACTOR")
      ->capture_default_str();
  command.add_option("--seed", flags.tree.seed, "Seed of the random numbers")->type_name("N")->capture_default_str();
  command.add_option("--threads", flags.threads, "Number of threads, 0: all cores; the bytes do not depend on it")
      ->type_name("N")
      ->check(CLI::NonNegativeNumber)
      ->capture_default_str();
  command.add_flag("--force", flags.force, "Overwrite --out");
  command.add_flag("--json", flags.json, "Print the result as JSON");
  command.add_flag("--quiet", flags.quiet, "Print errors only");
}

}  // namespace

void add_vocabulary_command(CLI::App& app, Context& context) {
  CLI::App* command = app.add_subcommand("vocabulary", "Trains a visual vocabulary for place recognition");
  const auto flags = std::make_shared<VocabularyFlags>();
  add_flags(*command, *flags);
  command->footer(vocabulary_footer);
  command->callback([flags, &context] {
    if (flags->quiet) set_log_sink({});
    train(*flags);
    context.exit_code = done;
  });
}

}  // namespace rastro::cli
