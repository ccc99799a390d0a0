// SPDX-License-Identifier: Apache-2.0
#include "rastro/export/place_plot.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstddef>

#include "rastro/base/error.h"
#include "rastro/export/trajectory_plot.h"
#include "rastro/export/trajectory_plot_panel.h"
#include "rastro/export/trajectory_plot_pen.h"

namespace rastro {
namespace {

constexpr int sheet_width = 1400, sheet_height = 1040;
constexpr double left_px = 80.0, frame_width_px = 1285.0;
constexpr PlotColor black{30, 30, 30}, gray{150, 150, 150}, orange{230, 130, 0}, blue{31, 119, 180},
    light_blue{175, 205, 232}, green{20, 150, 40}, red{220, 40, 40};

double number_of(KeyframeId id) { return static_cast<double>(id); }

class Sheet {
 public:
  explicit Sheet(const std::vector<PlaceBelief>& places) : places_(places) {
    for (const PlaceBelief& place : places) {
      last_ = std::max(last_, place.keyframe);
      matches_ += place.accepted.size();
      rejections_ += place.rejected.size();
    }
    first_ = places.front().keyframe;
    last_ = std::max(last_, first_ + 1);
  }

  void draw(PlotPen& pen) const {
    pen.text(fmt::format("Places: {} keyframes, {} matches with earlier places, {} rejected", places_.size(), matches_,
                         rejections_),
             {left_px, 30.0}, TextAnchor::left, 18.0, black);
    draw_legend(pen);
    draw_panel(probabilities(), pen);
    draw_panel(locations(), pen);
    if (nothing_known())
      pen.text("no place was left long enough ago to be looked for", {left_px + 0.5 * frame_width_px, 710.0},
               TextAnchor::middle, 16.0, black);
  }

 private:
  bool nothing_known() const {
    return matches_ + rejections_ == 0 && std::all_of(places_.begin(), places_.end(), [](const PlaceBelief& place) {
             return place.likely == no_keyframe;
           });
  }

  PlotPanel panel(double top_px, double height_px, const char* title, const char* x_label) const {
    PlotPanel panel;
    panel.corner = {left_px, top_px};
    panel.size = {frame_width_px, height_px};
    panel.title = title;
    panel.x_label = x_label;
    return panel;
  }

  PlotPanel probabilities() const {
    PlotPanel panel = this->panel(100.0, 300.0, "probability", "");
    panel.range = {{{number_of(first_), 0.0}, {number_of(last_), 1.0}}};
    PlotCurve new_place{{}, gray}, likely{{}, blue};
    PlotDots accepted{{}, green, 3.0}, rejected{{}, red, 3.0};
    for (const PlaceBelief& place : places_) {
      const Eigen::Vector2d at(number_of(place.keyframe), place.probability);
      new_place.points.emplace_back(at.x(), place.new_place);
      likely.points.push_back(at);
      const auto& in_vain = place.rejected;
      if (!place.accepted.empty())
        accepted.points.push_back(at);
      else if (std::find(in_vain.begin(), in_vain.end(), place.likely) != in_vain.end())
        rejected.points.push_back(at);
    }
    const double threshold = places_.back().threshold;
    panel.curves = {new_place, {{{number_of(first_), threshold}, {number_of(last_), threshold}}, orange}, likely};
    panel.dots = {rejected, accepted};
    return panel;
  }

  PlotPanel locations() const {
    PlotPanel panel = this->panel(450.0, 530.0, "earlier location (its keyframe)", "keyframe");
    PlotDots unlikely{{}, light_blue, 2.0}, likely{{}, blue, 2.0}, accepted{{}, green, 3.0}, rejected{{}, red, 1.5};
    double lowest = number_of(first_);
    const auto add = [&lowest](PlotDots& dots, KeyframeId from, KeyframeId to) {
      dots.points.emplace_back(number_of(to), number_of(from));
      lowest = std::min(lowest, number_of(from));
    };
    for (const PlaceBelief& place : places_) {
      if (place.likely != no_keyframe)
        add(place.probability < place.threshold ? unlikely : likely, place.likely, place.keyframe);
      for (const KeyframeId id : place.rejected) add(rejected, id, place.keyframe);
      for (const KeyframeId id : place.accepted) add(accepted, id, place.keyframe);
    }
    panel.range = {{{number_of(first_), lowest}, {number_of(last_), number_of(last_)}}};
    panel.curves = {{{{number_of(first_), number_of(first_)}, {number_of(last_), number_of(last_)}}, gray}};
    panel.dots = {unlikely, rejected, likely, accepted};
    return panel;
  }

  void draw_legend(PlotPen& pen) const {
    double x = left_px;
    const auto entry = [&](const std::string& name, PlotColor color, double radius) {
      const Eigen::Vector2d at(x, 58.0);
      if (radius > 0.0)
        pen.dot(at + Eigen::Vector2d(15.0, 0.0), color, radius);
      else
        pen.line({at, at + Eigen::Vector2d(30.0, 0.0)}, color, 2.0);
      pen.text(name, at + Eigen::Vector2d(38.0, 5.0), TextAnchor::left, 14.0, black);
      constexpr double letter_px = 8.5;
      x += 70.0 + letter_px * static_cast<double>(name.size());
    };
    entry("new place", gray, 0.0);
    entry("most likely location", blue, 0.0);
    entry("below the threshold", light_blue, 3.0);
    entry(fmt::format("threshold {:g}", places_.back().threshold), orange, 0.0);
    entry("matched", green, 3.0);
    entry("compared in vain", red, 3.0);
  }

  const std::vector<PlaceBelief>& places_;
  KeyframeId first_ = 0, last_ = 0;
  std::size_t matches_ = 0, rejections_ = 0;
};

}  // namespace

void write_place_plot(const std::vector<PlaceBelief>& places, const std::string& file) {
  require_plot_name(file);
  if (places.empty()) throw Error("there are no places to plot", file, "a method that recognizes places tells of them");
  const auto pen = pen_for(file, sheet_width, sheet_height);
  Sheet(places).draw(*pen);
  pen->save(file);
}

}  // namespace rastro
