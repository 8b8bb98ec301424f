// SPDX-License-Identifier: MIT
#pragma once

/// The main header of the component `detect`, which needs OpenCV.
///
/// findBoard() finds a whole or partly visible board in a grey image, with the standard deviation of each
/// corner in pixels. surveyImages() does this for many image files in parallel and excludes images that must
/// not be used together. BoardSurvey::views() is the input of a calibration. openImages() gives the images of
/// folders, files and videos, and readGrayImage() reads one. Pixel (0, 0) is the centre of the top-left
/// pixel. Errors are thrown as alidade::Error.
///
///     const alidade::Checkerboard board{.columns = 9, .rows = 6, .square_m = 0.025};
///     const std::vector<std::string> inputs = {"photos", "video.mp4"};
///     const alidade::BoardSurvey survey = alidade::surveyImages(alidade::openImages(inputs), board);
///     for (const alidade::ImageOutcome& outcome : survey.outcomes)
///       if (const auto why = alidade::diagnosisOf(outcome)) std::puts(why->message().c_str());
///     for (const alidade::View& view : survey.views())
///       std::printf("%s: %zu corners\n", view.image.c_str(), view.corners.size());
#include "alidade/core/error.h"
#include "alidade/detect/detect_images.h"
#include "alidade/detect/survey.h"
#include "alidade/imagery/image_file.h"
#include "alidade/imagery/image_set.h"
