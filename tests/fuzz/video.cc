// SPDX-License-Identifier: MIT
// Videos, through everything that comes before the pixels are used. The first inputs are two or four frames
// of 64x48 pixels from writeVideo() of tests/imagery/coded_video.h, named by codec and container, without
// padding in AVI.
#include "alidade/imagery/video_reader.h"

#include "alidade/imagery/frame_choice.h"
#include "fuzz.h"
#include "memory_file.h"

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace alidade;
  const fuzz::MemoryFile file(data, size);
  fuzz::read([&] {
    // Large frames and long videos are allowed, but would take all the time.
    constexpr std::int64_t kMaxPixels = 50'000;
    constexpr std::size_t kMaxFrames = 200;
    VideoReader reader(file.path(), {.max_pixels = kMaxPixels});
    FrameChooser chooser(4);
    for (std::size_t i = 0; i < kMaxFrames && reader.advance(); ++i) {
      expect(reader.number() == i, "frames in their order");
      (void)reader.seconds();
      const GrayImage image = reader.image().image;
      expect(image.pixels.size() ==
                 static_cast<std::size_t>(image.size.width) * static_cast<std::size_t>(image.size.height),
             "as many pixels as the size says");
      if (reader.isIntact()) chooser.add(i, lookAt(image));
    }
    (void)chooser.chosen();
    const double missing = reader.missingShare();
    expect(missing >= 0 && missing <= 1, "a share");
  });
  return 0;
}
