// SPDX-License-Identifier: MIT
#include "files/formats/format_tables.h"
#include "alidade/camera/camera_variant.h"

#include <algorithm>
#include <optional>
#include <span>

#include <gtest/gtest.h>

#include "alidade/core/error.h"
#include "alidade/core/text.h"
#include "alidade/files/camera_source.h"
#include "alidade/files/formats/camera_format.h"
#include "support/grid_difference.h"
#include "support/model_fixture.h"

namespace alidade {
namespace {

constexpr double kTolerance = 1e-9;  // px
constexpr int kNumRandom = 3;        // cameras of each model

// Cameras of a model with all parameters at work.
std::vector<AnyCamera> camerasOf(std::string_view model_id) {
  std::vector<AnyCamera> cameras;
  AllModels::forEach([&]<class M>() {
    if (M::kId != model_id) return;
    cameras.emplace_back(Camera<M>(ModelFixture<M>::paramSets().front()));
    Random random(7);
    for (int i = 0; i < kNumRandom; ++i)
      cameras.emplace_back(Camera<M>(ModelFixture<M>::randomParams(random)));
  });
  return cameras;
}

AnyCamera without(std::span<const std::string_view> absent, const AnyCamera& camera) {
  std::vector<double> parameters(camera.parameters().begin(), camera.parameters().end());
  for (const std::string_view name : absent)
    parameters.at(parameterIndex(camera.parameterNames(), name).value()) = 0;
  return AnyCamera::make(camera.modelId(), parameters);
}

// The camera that a file of it holds, if a format has a place for it.
std::optional<AnyCamera> throughFile(const CameraFormat& format, const AnyCamera& camera) {
  if (format.write == nullptr) return std::nullopt;
  std::string text;
  try {
    text = formatText(format,
                      std::vector<NamedCamera>{{.name = "", .camera = camera, .image_size = kTestImage}});
  } catch (const Error& error) {
    EXPECT_NE(std::string(error.what()).find("--model"), std::string::npos) << error.what();
    return std::nullopt;
  }
  ReadOptions options;
  if (!format.holds_size) options.image_size = kTestImage;
  const CameraSource source = parseCameras(text, "file", options);
  EXPECT_EQ(source.format, format.id);
  EXPECT_EQ(source.cameras.size(), 1u);
  EXPECT_EQ(source.cameras.front().image_size, std::optional(kTestImage));
  EXPECT_TRUE(source.cameras.front().remarks.empty())
      << format.id << ": " << source.cameras.front().remarks.front().message;
  return source.cameras.front().camera;
}

void expectSame(const AnyCamera& camera, const AnyCamera& back, const std::string& where) {
  const GridDifference difference = gridDifference(camera, back, kTestImage);
  EXPECT_LT(difference.worst_px, kTolerance) << where;
  EXPECT_GE(difference.num_points, 50) << where;  // some random lenses see a part of the image
}

std::span<const CameraFormat* const> formats() {
  return cameraFormats();
}

// Writes cameras of a model as a format and compares them with what it says of itself.
void expectHeld(const CameraFormat& format, const std::string& model, const HeldModel* held) {
  if (format.write == nullptr) return;
  for (const AnyCamera& camera : camerasOf(model)) {
    const std::string where = std::string(format.id) + ", " + model;
    const auto back = throughFile(format, camera);
    const bool has_absent = held != nullptr && std::ranges::any_of(held->absent, [&](std::string_view name) {
                              return camera.parameter(name) != 0;
                            });
    EXPECT_EQ(back.has_value(), held != nullptr && !has_absent) << where;
    if (back) expectSame(camera, *back, where);
    if (held == nullptr || held->absent.empty()) continue;
    const AnyCamera reduced = without(held->absent, camera);
    const auto reduced_back = throughFile(format, reduced);
    ASSERT_TRUE(reduced_back) << where;
    expectSame(reduced, *reduced_back, where);
  }
}

std::string formatRow(const CameraFormat& format) {
  std::vector<std::string> texts;
  const std::vector<HeldModel> all = heldModels(format);
  std::size_t num_plain = 0;
  for (const std::string& model : modelIds()) {
    const auto held = std::ranges::find(all, std::string_view(model), &HeldModel::model);
    expectHeld(format, model, held == all.end() ? nullptr : &*held);
    if (held == all.end()) continue;
    num_plain += held->as == held->model && held->absent.empty() ? 1 : 0;
    texts.push_back(
        "`" + model + "`" +
        (!held->absent.empty()
             ? " (" + join(std::vector<std::string>(held->absent.begin(), held->absent.end()), ", ") + " = 0)"
         : held->as != held->model ? " as `" + std::string(held->as) + "`"
                                   : ""));
  }
  return "| `" + std::string(format.id) + "` | " +
         (num_plain == modelIds().size() ? "all" : join(texts, ", ")) + " | " + format.camerasText() + " | " +
         (format.holdsPoses()       ? "yes"
          : !format.reads_poses     ? "-"
          : format.write == nullptr ? "yes"
                                    : "read") +
         " | " + (format.write == nullptr ? "read" : "read, written") + " |\n";
}

std::string formatTable() {
  std::string text = "| format | models held exactly | cameras | poses | |\n|---|---|---|---|---|\n";
  for (const CameraFormat* format : formats()) text += formatRow(*format);
  return text;
}

// Does a camera get from one format to the other and back? `start` is what the first holds of it.
bool survives(const CameraFormat& from, const CameraFormat& to, const AnyCamera& camera,
              const AnyCamera& start) {
  const auto there = throughFile(to, start);
  if (!there) return false;
  const std::string where =
      std::string(from.id) + " to " + std::string(to.id) + ", " + std::string(camera.modelId());
  expectSame(camera, *there, where);
  const auto back = throughFile(from, *there);
  EXPECT_TRUE(back) << where << " and back";
  if (back) expectSame(camera, *back, where + " and back");
  return true;
}

}  // namespace

std::string formatTables() {
  return "\n" + formatTable() + "\n";
}

int countConversions() {
  int num_survivors = 0;
  for (const CameraFormat* from : formats()) {
    for (const std::string_view model : from->models) {
      const AnyCamera camera = camerasOf(model).front();
      const std::vector<std::string_view> absent = {"k3"};  // of radtan, which some formats lack
      const AnyCamera without_k3 = model == "radtan" ? without(absent, camera) : camera;
      const auto start = throughFile(*from, camera);
      const auto start_without_k3 = throughFile(*from, without_k3);
      for (const CameraFormat* to : formats()) {
        const bool survives_whole = start && survives(*from, *to, camera, *start);
        const bool survives_without =
            !survives_whole && start_without_k3 && survives(*from, *to, without_k3, *start_without_k3);
        if (survives_whole || survives_without) ++num_survivors;
      }
    }
  }
  return num_survivors;
}

}  // namespace alidade
