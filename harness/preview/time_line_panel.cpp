#include <fmt/format.h>
#include <imgui.h>

#include <algorithm>

#include "harness/preview/panels.h"

namespace stbvh::harness {
namespace {

constexpr const char* kAxisNames[] = {"x", "y", "z"};

/// From time and space to the window: time to the right, space upwards.
class Plot {
 public:
  Plot(ImVec2 corner, ImVec2 size, const TimeLineNode& whole)
      : corner_(corner), size_(size), whole_(whole.time_range) {
    lower_ = std::min(whole.at_begin[0], whole.at_end[0]);
    upper_ = std::max(whole.at_begin[1], whole.at_end[1]);
  }

  void extend(const TimeLineNode& node) {
    lower_ = std::min({lower_, node.at_begin[0], node.at_end[0]});
    upper_ = std::max({upper_, node.at_begin[1], node.at_end[1]});
  }

  ImVec2 at(float time, float place) const {
    const float length = std::max(whole_.end - whole_.begin, 1e-6f),
                height = std::max(upper_ - lower_, 1e-20f);
    return {corner_.x + size_.x * (time - whole_.begin) / length,
            corner_.y + size_.y * (upper_ - place) / height};
  }
  float lower() const { return lower_; }
  float upper() const { return upper_; }

 private:
  ImVec2 corner_, size_;
  TimeRange whole_;
  float lower_, upper_;
};

/// `fill`: opacity of the inside, 0 to 255; many nodes lie over each other.
void draw_node(ImDrawList& list, const Plot& plot, const TimeLineNode& node, float thickness, int fill) {
  const Rgb rgb = tree_color(node.is_timed, node.time_range, node.kind != NodeKind::kStatic);
  const ImVec2 corners[] = {
      plot.at(node.time_range.begin, node.at_begin[0]), plot.at(node.time_range.end, node.at_end[0]),
      plot.at(node.time_range.end, node.at_end[1]), plot.at(node.time_range.begin, node.at_begin[1])};
  list.AddConvexPolyFilled(corners, 4, IM_COL32(rgb[0], rgb[1], rgb[2], fill));
  list.AddPolyline(corners, 4, IM_COL32(rgb[0], rgb[1], rgb[2], 190), ImDrawFlags_Closed, thickness);
}

}  // namespace

void draw_time_line(PreviewModel& model, const WindowArea& area, float scale) {
  TreeOptions& tree = model.tree_options;
  if (!tree.shows_time_line || model.tree() == nullptr) return;
  const float height = std::min(260 * scale, 0.5f * area.height);
  ImGui::SetNextWindowPos({area.x, area.y + area.height - height}, ImGuiCond_Always);
  ImGui::SetNextWindowSize({area.width, height}, ImGuiCond_Always);
  ImGui::SetNextWindowBgAlpha(0.8f);
  const std::string title = fmt::format("Bounds along {} over time###time line", kAxisNames[tree.axis]);
  if (ImGui::Begin(title.c_str(), &tree.shows_time_line,
                   ImGuiWindowFlags_NoResize | ImGuiWindowFlags_NoMove)) {
    const TimeLine line = model.time_line();
    const ImVec2 corner = ImGui::GetCursorScreenPos(), room = ImGui::GetContentRegionAvail();
    const float text_height = ImGui::GetTextLineHeightWithSpacing();
    const ImVec2 size{std::max(room.x, 1.0f), std::max(room.y - text_height, 1.0f)};
    Plot plot(corner, size, line.subtree);
    for (const TimeLineNode& node : line.nodes) plot.extend(node);
    ImDrawList& list = *ImGui::GetWindowDrawList();
    const int fill = 3 + 400 / static_cast<int>(line.nodes.size() + 10);
    for (const TimeLineNode& node : line.nodes) draw_node(list, plot, node, scale, fill);
    const auto time = static_cast<float>(model.animation.shutter().open);
    const float now = model.animation.is_playing ? time : static_cast<float>(model.animation.time());
    list.AddLine(plot.at(now, plot.lower()), plot.at(now, plot.upper()), IM_COL32(255, 255, 255, 255), scale);
    ImGui::Dummy(size);
    const std::string legend =
        fmt::format("{}{} nodes; time {:.3f} to {:.3f}, {} from {:.4g} to {:.4g}", line.nodes.size(),
                    line.is_complete ? "" : " and more", line.subtree.time_range.begin,
                    line.subtree.time_range.end, kAxisNames[tree.axis], plot.lower(), plot.upper());
    ImGui::TextUnformatted(legend.c_str());
  }
  ImGui::End();
}

}  // namespace stbvh::harness
