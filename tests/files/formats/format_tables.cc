// SPDX-License-Identifier: MIT
#include "files/formats/format_tables.h"
#include "alidade/camera/camera_variant.h"

#include <optional>

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

AnyCamera withoutK3(const AnyCamera& camera) {
  std::vector<double> parameters(camera.parameters().begin(), camera.parameters().end());
  const auto names = camera.parameterNames();
  const auto k3 = std::find(names.begin(), names.end(), "k3") - names.begin();
  if (k3 < static_cast<std::ptrdiff_t>(parameters.size())) parameters[static_cast<std::size_t>(k3)] = 0;
  return AnyCamera::make(camera.modelId(), parameters);
}

// The camera that a file of it holds, if a format has a place for it.
std::optional<AnyCamera> throughFile(const CameraFormat& format, const AnyCamera& camera) {
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

std::vector<const CameraFormat*> formats() {
  return {cameraFormats().begin(), cameraFormats().end()};
}

// What a format does with all cameras of a model: "yes", the model that it holds them as, or nothing.
std::optional<std::string> howHeld(const CameraFormat& format, const std::vector<AnyCamera>& cameras) {
  std::optional<std::string> held;
  for (std::size_t i = 0; i < cameras.size(); ++i) {
    const auto back = throughFile(format, cameras[i]);
    const std::string where = std::string(format.id) + ", " + std::string(cameras[i].modelId());
    if (i > 0) {
      EXPECT_EQ(back.has_value(), held.has_value()) << where;
    }
    if (!back) continue;
    expectSame(cameras[i], *back, where);
    const bool is_same_model = back->modelId() == cameras[i].modelId();
    held = is_same_model ? "yes" : "as " + std::string(back->modelId());
  }
  return held;
}

std::string modelTable() {
  std::string header = "| model |";
  std::string line = "|---|";
  for (const CameraFormat* format : formats()) {
    header += " " + std::string(format->id) + " |";
    line += "---|";
  }
  std::string rows;
  for (const std::string& model : modelIds()) {
    rows += "| `" + model + "` |";
    const std::vector<AnyCamera> cameras = camerasOf(model);
    std::vector<AnyCamera> without_k3;
    for (const AnyCamera& camera : cameras) without_k3.push_back(withoutK3(camera));
    for (const CameraFormat* format : formats()) {
      std::string cell = howHeld(*format, cameras).value_or("");
      if (cell.empty() && howHeld(*format, without_k3)) cell = "k3 = 0";
      rows += " " + (cell.empty() ? "-" : cell) + " |";
    }
    rows += "\n";
  }
  return header + "\n" + line + "\n" + rows;
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
  return "\n" + modelTable() + "\n";
}

int countConversions() {
  int num_survivors = 0;
  for (const CameraFormat* from : formats()) {
    for (const std::string_view model : from->models) {
      const AnyCamera camera = camerasOf(model).front();
      const AnyCamera without_k3 = withoutK3(camera);
      const auto start = throughFile(*from, camera);
      const auto start_without_k3 = throughFile(*from, without_k3);
      for (const CameraFormat* to : formats()) {
        const bool survives_whole = start && survives(*from, *to, camera, *start);
        const bool survives_without = !survives_whole && model == "radtan" && start_without_k3 &&
                                      survives(*from, *to, without_k3, *start_without_k3);
        if (survives_whole || survives_without) ++num_survivors;
      }
    }
  }
  return num_survivors;
}

}  // namespace alidade
