// SPDX-License-Identifier: MIT
// What AnyCamera holds, for the library's own loops: programs need neither the models nor the time that it
// takes to compile them.
#pragma once

#include <memory>
#include <utility>
#include <variant>

#include "alidade/camera/any_camera.h"
#include "alidade/camera/camera.h"
#include "alidade/camera/model_list.h"

namespace alidade {

namespace detail {
struct CameraVariant {
  AllModels::Variant<Camera> camera;
};
}  // namespace detail

template <class M>
AnyCamera::AnyCamera(const Camera<M>& camera)
    : camera_(std::make_shared<const detail::CameraVariant>(detail::CameraVariant{camera})) {}

template <class F>
decltype(auto) AnyCamera::visit(F&& f) const {
  return std::visit(std::forward<F>(f), camera_->camera);
}

}  // namespace alidade
