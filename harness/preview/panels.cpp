#include "harness/preview/panels.h"

#include <fmt/format.h>
#include <imgui.h>
#include <imgui_stdlib.h>

#include <algorithm>
#include <string_view>

#include "harness/program/usage_error.h"
#include "harness/scenes/moving_triangle.h"
#include "harness/scenes/procedural/procedural.h"

namespace stbvh::harness {
namespace {

constexpr float kPanelWidth = 330;  // in pixels of the user
constexpr ImU32 kWarning = IM_COL32(255, 205, 80, 255);

template <typename... Arguments>
void text(fmt::format_string<Arguments...> format, Arguments&&... arguments) {
  const std::string line = fmt::format(format, std::forward<Arguments>(arguments)...);
  ImGui::TextUnformatted(line.data(), line.data() + line.size());
}

/// A slider over a double.
bool slider(const char* label, double& value, double least, double largest, const char* format = "%.3f",
            ImGuiSliderFlags flags = 0) {
  return ImGui::SliderScalar(label, ImGuiDataType_Double, &value, &least, &largest, format, flags);
}

bool count_slider(const char* label, std::size_t& value, int least, int largest) {
  int number = static_cast<int>(value);
  const bool is_changed =
      ImGui::SliderInt(label, &number, least, largest, "%d", ImGuiSliderFlags_AlwaysClamp);
  if (is_changed) value = static_cast<std::size_t>(number);
  return is_changed;
}

void draw_scene(PreviewModel& model) {
  const SessionState& state = model.state();
  const std::string shown = state.structures[0] ? state.structures[0]->scene->name : "none";
  if (ImGui::BeginCombo("Scene", shown.c_str())) {
    for (const ProceduralScene& scene : procedural_scenes()) {
      const std::string name(scene.name);
      if (ImGui::Selectable(name.c_str(), name == shown)) model.open(name);
      if (ImGui::IsItemHovered()) ImGui::SetTooltip("%s", std::string(scene.description).c_str());
    }
    ImGui::EndCombo();
  }
  if (state.structures[0]) {
    const Scene& scene = *state.structures[0]->scene;
    text("{} triangles, {} meshes", scene.triangle_count(), scene.meshes.size());
  }
  const LoadProgress loading = model.load_progress();
  if (loading.is_busy) {
    ImGui::ProgressBar(static_cast<float>(loading.fraction), {-1, 0}, loading.stage.c_str());
    if (ImGui::Button("Cancel")) model.cancel();
  }
  const std::string message = model.message();
  if (!message.empty()) {
    ImGui::PushStyleColor(ImGuiCol_Text, kWarning);
    ImGui::TextWrapped("%s", message.c_str());
    ImGui::PopStyleColor();
  }
}

void draw_structure_choice(PreviewModel& model, std::size_t slot) {
  const std::string& chosen = model.chosen_structures()[slot];
  if (!ImGui::BeginCombo(slot == 0 ? "A" : "B", chosen.empty() ? "none" : chosen.c_str())) return;
  if (slot > 0 && ImGui::Selectable("none", chosen.empty())) model.choose_structure(slot, "");
  for (std::string_view structure : structure_names()) {
    const std::string name(structure);
    if (ImGui::Selectable(name.c_str(), name == chosen)) model.choose_structure(slot, name);
    if (ImGui::IsItemHovered())
      ImGui::SetTooltip("%s", std::string(structure_description(structure)).c_str());
  }
  ImGui::EndCombo();
}

void draw_figures(const SessionState& state) {
  if (!ImGui::BeginTable("figures", 3, ImGuiTableFlags_BordersInnerV)) return;
  ImGui::TableSetupColumn("", ImGuiTableColumnFlags_WidthStretch, 2);
  ImGui::TableSetupColumn("", ImGuiTableColumnFlags_WidthStretch, 1.4f);
  ImGui::TableSetupColumn("", ImGuiTableColumnFlags_WidthStretch, 1.4f);
  const auto row = [&](const char* name, auto value) {
    ImGui::TableNextRow();
    ImGui::TableNextColumn();
    ImGui::TextUnformatted(name);
    for (std::size_t slot = 0; slot < kSlots; ++slot) {
      ImGui::TableNextColumn();
      if (state.structures[slot]) text("{}", value(slot));
    }
  };
  const PictureFigures& figures = state.figures;
  const auto record = [&](std::size_t slot) { return state.structures[slot]->structure->build_record(); };
  row("", [](std::size_t slot) { return slot == 0 ? "A" : "B"; });
  row("build, ms", [&](std::size_t s) { return fmt::format("{:.1f}", 1e3 * record(s).build_s); });
  row("MB", [&](std::size_t s) {
    return fmt::format("{:.2f}", static_cast<double>(record(s).structure_bytes) / 1e6);
  });
  row("Mrays/s a thread",
      [&](std::size_t s) { return fmt::format("{:.3f}", figures.mrays_per_thread_second(s)); });
  row("leaks", [&](std::size_t s) { return fmt::format("{}", figures.leaks[s]); });
  ImGui::EndTable();
  if (state.structures[1]) {
    text("another triangle in A than in B: {}", figures.mismatches);
    text("of {} camera rays", figures.compared);
  }
}

void draw_structures(PreviewModel& model) {
  draw_structure_choice(model, 0);
  draw_structure_choice(model, 1);
  draw_figures(model.state());
  for (std::size_t slot = 0; slot < kSlots; ++slot) {
    if (model.is_building(slot)) text("{}: building", slot == 0 ? "A" : "B");
  }
  const PictureFigures& figures = model.state().figures;
  text("{} of {} samples, {:.1f} s", figures.samples, model.most_samples(), figures.seconds);
}

void draw_view(PreviewModel& model) {
  ViewOptions& view = model.view_options;
  constexpr std::array<const char*, 4> kModes{"A (1)", "B (2)", "Split (3)", "A-B (4)"};
  for (std::size_t i = 0; i < kModes.size(); ++i) {
    if (i > 0) ImGui::SameLine();
    if (ImGui::RadioButton(kModes[i], view.mode == static_cast<ViewMode>(i)))
      view.mode = static_cast<ViewMode>(i);
  }
  if (view.mode == ViewMode::kSplit) slider("Split", view.split, 0, 1);
  if (view.mode == ViewMode::kDifference)
    slider("Gain", view.gain, 1, 10000, "%.0f", ImGuiSliderFlags_Logarithmic);
  constexpr const char* kHeats = "none\0nodes of a camera ray\0triangles of a camera ray\0";
  int heat = static_cast<int>(view.heat);
  if (ImGui::Combo("Heat map", &heat, kHeats)) view.heat = static_cast<HeatMap>(heat);
  if (view.heat != HeatMap::kNone) {
    slider("Lightest at", view.heat_largest, 4, 1000, "%.0f", ImGuiSliderFlags_Logarithmic);
    ImGui::TextUnformatted("grey: only structures without Embree count");
  }
}

void draw_mesh_table(const PreviewModel& model) {
  if (!model.state().structures[0] || !ImGui::TreeNode("Steps of each mesh")) return;
  const std::vector<Mesh>& meshes = model.state().structures[0]->scene->meshes;
  const auto time = static_cast<float>(model.animation.shutter().open);
  if (ImGui::BeginTable("meshes", 3, ImGuiTableFlags_ScrollY | ImGuiTableFlags_RowBg,
                        {0, 8 * ImGui::GetTextLineHeightWithSpacing()})) {
    ImGui::TableSetupScrollFreeze(0, 1);
    ImGui::TableSetupColumn("mesh");
    ImGui::TableSetupColumn("steps");
    ImGui::TableSetupColumn("between");
    ImGui::TableHeadersRow();
    ImGuiListClipper clipper;
    for (clipper.Begin(static_cast<int>(meshes.size())); clipper.Step();) {
      for (int i = clipper.DisplayStart; i < clipper.DisplayEnd; ++i) {
        const Mesh& mesh = meshes[static_cast<std::size_t>(i)];
        ImGui::TableNextColumn();
        text("{}", mesh.name);
        ImGui::TableNextColumn();
        text("{}", mesh.steps.size());
        ImGui::TableNextColumn();
        if (mesh.is_static()) {
          ImGui::TextUnformatted("static");
        } else if (is_visible_at(mesh, time)) {
          const std::size_t k = motion_sample(mesh, time).segment;
          text("{} and {}", k, k + 1);
        } else {
          ImGui::TextUnformatted("not there");
        }
      }
    }
    ImGui::EndTable();
  }
  ImGui::TreePop();
}

void draw_time(PreviewModel& model) {
  Animation& animation = model.animation;
  double time = animation.time();
  if (slider("Time", time, 0, 1)) animation.scrub(time);
  int shutter = animation.is_frozen ? 1 : animation.is_whole ? 0 : 2;
  if (ImGui::Combo("Shutter", &shutter, "all the time\0a moment\0a part of each frame\0")) {
    animation.is_whole = shutter == 0;
    animation.is_frozen = shutter == 1;
  }
  if (shutter == 2) slider("of a frame", animation.shutter_share, 0, 1);
  ImGui::Checkbox("Play (space)", &animation.is_playing);
  count_slider("Frames", animation.frames, 1, 240);
  slider("Seconds", animation.seconds, 0.5, 60, "%.1f");
  const Shutter open = animation.shutter();
  text("open from {:.4f} to {:.4f}", open.open, open.close);
  text("{} frames played, {} builds", model.frames_played(), model.load_progress().builds);
  draw_mesh_table(model);
}

void draw_camera(PreviewModel& model) {
  double fov = static_cast<double>(model.camera.camera().vertical_fov_degrees);
  if (slider("Angle of view", fov, 5, 120, "%.1f")) model.camera.set_fov(fov);
  const Camera camera = model.camera.camera();
  const double distance = length(to_double(camera.target) - to_double(camera.position));
  slider("Lens radius", model.lens_radius, 0, 0.1 * distance, "%.4f");
  if (model.state().structures[0] && ImGui::Button("Back to the scene's camera"))
    model.camera = CameraController(model.state().structures[0]->scene->camera);
}

void draw_tree(PreviewModel& model) {
  TreeOptions& tree = model.tree_options;
  if (model.tree() == nullptr) {
    ImGui::TextWrapped("Choose stbvh-direct or stbvh-batch to see its tree.");
    return;
  }
  ImGui::Checkbox("Boxes (t)", &tree.shows_boxes);
  if (tree.shows_boxes) {
    count_slider("Level", tree.level, 0, 30);
    text("{}{} boxes at time {:.3f}", model.boxes().boxes.size(),
         model.boxes().is_complete ? "" : " and more", model.animation.time());
    ImGui::TextWrapped("blue to red: there for a part of the time; white: always, moving; grey: still");
  }
  ImGui::Checkbox("Time line", &tree.shows_time_line);
  if (tree.shows_time_line) {
    int axis = static_cast<int>(tree.axis);
    if (ImGui::Combo("Axis", &axis, "x\0y\0z\0")) tree.axis = static_cast<std::size_t>(axis);
    count_slider("Subtree's level", tree.subtree_level, 0, 30);
    count_slider("Levels below", tree.depth, 0, 12);
    ImGui::TextWrapped("Ctrl-click: the subtree that holds the triangle there");
  }
}

void draw_saving(PreviewModel& model, PanelState& panels, Window& window) {
  ImGui::InputText("File", &panels.save_path);
  if (ImGui::Button("Save PNG and EXR (s)")) model.save(panels.save_path);
  ImGui::SameLine();
  if (ImGui::Button("Copy command (c)")) window.copy(model.command_line());
}

}  // namespace

WindowArea picture_area(const PanelState& panels, float width, float height, float scale) {
  const float panel = kPanelWidth * scale;
  if (!panels.is_shown || width < 2 * panel) return {0, 0, width, height};
  return {panel, 0, width - panel, height};
}

void draw_panels(PreviewModel& model, PanelState& panels, const FrameTimes& times, const WindowArea& area,
                 Window& window) {
  draw_time_line(model, area, window.scale());
  if (!panels.is_shown) return;
  const float width = kPanelWidth * window.scale();
  ImGui::SetNextWindowPos({0, 0});
  ImGui::SetNextWindowSize({std::min(width, ImGui::GetIO().DisplaySize.x), ImGui::GetIO().DisplaySize.y});
  ImGui::Begin("stbvh-preview", nullptr,
               ImGuiWindowFlags_NoMove | ImGuiWindowFlags_NoResize | ImGuiWindowFlags_NoCollapse |
                   ImGuiWindowFlags_NoTitleBar);
  ImGui::PushItemWidth(-0.4f * width);
  draw_scene(model);
  const auto part = [](const char* title, bool is_open) {
    return ImGui::CollapsingHeader(title, is_open ? ImGuiTreeNodeFlags_DefaultOpen : 0);
  };
  if (part("Structures", true)) draw_structures(model);
  if (part("View", true)) draw_view(model);
  if (part("Time", true)) draw_time(model);
  if (part("Camera", false)) draw_camera(model);
  if (part("Tree", true)) draw_tree(model);
  if (part("Save", false)) draw_saving(model, panels, window);
  text("{:.0f} frames a second (Tab hides this)", times.per_second());
  ImGui::PopItemWidth();
  ImGui::End();
}

}  // namespace stbvh::harness
