// SPDX-License-Identifier: MIT
#include "alidade/imagery/decoder_log.h"

#include <gmock/gmock.h>

#include "support/message_of.h"

namespace alidade {
namespace {

using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;

const std::string kBegin =
    "[info] Stream mapping:\n[info]   Stream #0:0 -> #0:0 (h264 (native) -> rawvideo (native))\n";

std::string packet(int ticks) {
  const std::string pts = std::to_string(ticks);
  return "[vist#0:0/h264 @ 0x1] [info] demuxer -> ist_index:0:0 type:video pkt_pts:" + pts +
         " pkt_pts_time:1\n";
}

const std::string kDecoded = "[vist#0:0/h264 @ 0x1] [dec:h264 @ 0x2] [info] decoder -> pts:0 keyframe:0\n";
const std::string kShowinfo = "[Parsed_showinfo_1 @ 0x3] [info] ";
const std::string kError = "[h264 @ 0x2] [error] error while decoding MB 3 4\n";
const std::string kColours =
    kShowinfo + "color_range:tv color_space:unknown color_primaries:bt709 color_trc:unknown";

std::string shown(int ticks, bool is_key = false, const std::string& format = "gray") {
  return kShowinfo + "n:   0 pts:  " + std::to_string(ticks) + " pts_time:0 fmt:" + format +
         " sar:1/1 s:64x48 i:P iskey:" + (is_key ? "1" : "0") + " type:P ";
}

VideoFacts h264() {
  VideoFacts facts;
  facts.container = "matroska,webm";
  facts.codec = "h264";
  facts.are_all_key = false;
  return facts;
}

std::vector<bool> intactFrames(const std::string& text, const VideoFacts& facts = h264()) {
  DecoderLog log("clip.mkv", facts);
  log.add(kBegin);
  for (const char c : text) log.add({&c, 1});  // in any pieces
  std::vector<bool> intact;
  for (const DecoderLog::Frame& frame : log.frames) intact.push_back(frame.is_intact);
  return intact;
}

TEST(DecoderLog, TellsWhatFramesAre) {
  const VideoFacts facts = h264();
  DecoderLog log("clip.mkv", facts);
  log.add(kBegin + packet(7) + kDecoded + shown(7, true, "gray10le") + "\n");
  ASSERT_EQ(log.frames.size(), 1u);
  EXPECT_EQ(log.frames.front().ticks, 7);
  EXPECT_EQ(log.frames.front().size, (ImageSize{64, 48}));
  EXPECT_EQ(log.frames.front().depth, 10);
  EXPECT_EQ(log.frames.front().high_byte, 1);
  EXPECT_FALSE(log.frames.front().is_interlaced);
  const auto complaint = [&](const std::string& text) {
    return messageOf([&] { DecoderLog("clip.mkv", facts).add(kBegin + text); });
  };
  EXPECT_THAT(complaint(kDecoded + shown(1, true, "gray10le") + "\n" + kDecoded + shown(2) + "\n"),
              AllOf(HasSubstr("clip.mkv"), HasSubstr("from gray10le to gray")));
  EXPECT_THAT(complaint(shown(1) + "\n"), HasSubstr("unknown form"));
  EXPECT_THAT(complaint(kDecoded + shown(1, false, "rgb24") + "\n"), HasSubstr("unknown form"));
}

// The demuxer and the decoder are ahead of the filters: the key frame 3 was decoded before the error.
TEST(DecoderLog, FlagsFramesFromAnErrorToALaterKeyFrame) {
  std::string text;
  for (int i = 1; i <= 4; ++i) text += packet(i);
  text += kDecoded + kDecoded + kDecoded + kError + kDecoded;
  for (int i = 1; i <= 4; ++i) text += shown(i, i == 3) + "\n" + kColours + "\n";
  EXPECT_THAT(intactFrames(text), ElementsAre(true, true, true, false));
  for (int i = 5; i <= 7; ++i) text += packet(i) + kDecoded + shown(i, i == 6) + "\n";
  EXPECT_THAT(intactFrames(text), ElementsAre(true, true, true, false, false, true, true));
}

TEST(DecoderLog, KnowsThatKeyFramesAloneDoNotSpreadDamage) {
  VideoFacts facts = h264();
  facts.are_all_key = true;
  const std::string lost =
      kError + "[dec:mjpeg @ 0x2] [error] Error submitting packet to decoder: Invalid data\n";
  const std::string text = packet(1) + packet(2) + packet(3) + kDecoded + lost + kDecoded + kError +
                           kDecoded + kDecoded + shown(1, true) + "\n" + shown(3, true) + "\n" +
                           shown(4, true) + "\n" + shown(5, true) + "\n";
  EXPECT_THAT(intactFrames(text, facts), ElementsAre(true, true, false, true));
  DecoderLog log("clip.mkv", facts);
  log.add(kBegin + text);
  EXPECT_EQ(log.frames[0].num_lost, 0u);
  EXPECT_EQ(log.frames[1].num_lost, 1u);
}

TEST(DecoderLog, FlagsFramesAfterPacketsThatAreMissing) {
  VideoFacts facts = h264();
  facts.gaps = {{.packet = 1, .is_fresh = false}, {.packet = 4, .is_fresh = true}, {.packet = 9}};
  std::string text;
  for (int i = 0; i < 6; ++i) text += packet(i) + kDecoded + shown(i, i == 3 || i == 4) + "\n";
  EXPECT_THAT(intactFrames(text, facts), ElementsAre(true, false, false, true, true, true));
  DecoderLog log("clip.mkv", facts);
  log.add(kBegin + text);
  EXPECT_EQ(log.frames.back().num_lost, 2u);
  EXPECT_EQ(log.numLostAtEnd(), 3u);
  // What the demuxer cannot read concerns the packets that follow.
  const std::string skipped = "[matroska,webm @ 0x4] [error] Invalid EBML number\n";
  EXPECT_THAT(intactFrames(packet(1) + kDecoded + skipped + shown(1) + "\n"), ElementsAre(true));
  EXPECT_THAT(
      intactFrames(packet(1) + kDecoded + shown(1) + "\n" + skipped + packet(2) + kDecoded + shown(2) + "\n"),
      ElementsAre(true, false));
}

// Another thread's message between the pieces of a line has no head of its own.
TEST(DecoderLog, SeparatesWhatThreadsSayAtOnce) {
  const std::string tail = shown(2) + "\n";
  const std::string headless = "decoder -> pts:0 keyframe:0\n";
  const std::string before = packet(1) + kDecoded + shown(1);
  EXPECT_THAT(intactFrames(before + headless + kColours + "\n" + tail), ElementsAre(true, true));
  EXPECT_THAT(intactFrames(before + "\n" + kColours + headless + kShowinfo + "\n" + tail),
              ElementsAre(true, true));
  const std::string error = "error while decoding MB 3 4\n";
  EXPECT_THAT(intactFrames(before + error + kDecoded + tail), ElementsAre(true, false));
  EXPECT_THAT(intactFrames(before + "\n" + kColours + error + kDecoded + tail), ElementsAre(true, false));
  EXPECT_THAT(intactFrames(before + "\n" + kShowinfo + "color_range:" + error + kDecoded + tail),
              ElementsAre(true, false));
  EXPECT_THAT(intactFrames(before + "muxer <- pts:1 size:640\n" + kDecoded + tail), ElementsAre(true, true));
}

TEST(DecoderLog, ReadsOnWhileTheOutputIsDescribed) {
  const std::string before =
      packet(1) + kDecoded + shown(1) + "\n[info]   Stream #0:0: Video: rawvideo, gray";
  const std::string after = "[info] , 30 fps, 30 tbn (default)\n" + shown(2) + "\n";
  EXPECT_THAT(intactFrames(before + "decoder -> pts:0 keyframe:0\n" + after), ElementsAre(true, true));
  EXPECT_THAT(intactFrames(before + "error while decoding MB 3 4\n" + kDecoded + after),
              ElementsAre(true, false));
  EXPECT_THAT(
      intactFrames(packet(1) + kDecoded + kColours + "  Stream #0:0: Video: rawvideo, gray, 30 tbn\n" +
                   shown(1) + "(default)\n" + kDecoded + shown(2) + "\n"),
      ElementsAre(true, true));
}

TEST(DecoderLog, IsNotMisledByWhatTheFileSays) {
  const VideoFacts facts = h264();
  DecoderLog log("clip.mkv", facts);
  log.add(
      "[info] Input #0, avi, from 'file:Error.avi':\n[info]     title           : decoder -> iskey:1 corrupt\n");
  log.add(kBegin + packet(1) + kDecoded + shown(1) + "\n");
  ASSERT_EQ(log.frames.size(), 1u);
  EXPECT_TRUE(log.frames.front().is_intact);
}

}  // namespace
}  // namespace alidade
