// SPDX-License-Identifier: MIT
#include "alidade/report/pages/view_sheet.h"

#include <algorithm>
#include <cstddef>
#include <numeric>
#include <string_view>

#include <fmt/format.h>

#include "alidade/core/mapped.h"
#include "alidade/report/canvas/figure_canvas.h"
#include "alidade/report/data/distinct_parts.h"
#include "alidade/report/figures/view_figures.h"
#include "alidade/report/pages/page_shell.h"

namespace alidade {
namespace {

constexpr std::string_view kViewer =
    "<dialog id=\"viewer\" aria-labelledby=\"viewer-name\"><div class=\"viewer\"><header><h3 "
    "id=\"viewer-name\"></h3><label>Errors drawn <select id=\"viewer-times\"><option value=\"1\">true to "
    "scale</option><option value=\"10\">10 times longer</option><option value=\"50\">50 times "
    "longer</option><option value=\"200\">200 times longer</option></select></label><span "
    "class=\"controls\"><button class=\"plain\" id=\"viewer-before\" type=\"button\" aria-label=\"Previous "
    "view\">←</button><button class=\"plain\" id=\"viewer-after\" type=\"button\" aria-label=\"Next "
    "view\">→</button><button class=\"plain\" id=\"viewer-close\" autofocus "
    "type=\"button\">Close</button></span></header><svg id=\"viewer-drawing\" role=\"img\" "
    "aria-labelledby=\"viewer-words\"></svg><footer><span id=\"viewer-words\"></span><span "
    "id=\"viewer-key\">circle: detected; cross: projected</span></footer></div></dialog>\n";

}  // namespace

std::string viewSheet(const ReportData& data, const std::vector<std::string>& pictures) {
  std::vector<std::size_t> order(data.views.size());
  std::iota(order.begin(), order.end(), 0);
  std::ranges::stable_sort(
      order, [&](std::size_t a, std::size_t b) { return data.views[a].rms_px > data.views[b].rms_px; });
  std::string html =
      "<figure id=\"view-sheet\" class=\"wide\"><h3>Views, the largest error first</h3><figcaption "
      "class=\"reading\">Open a view to see its detected corners (circles) and where the camera projects "
      "them (crosses).</figcaption><div class=\"sheet-of-views\">\n";
  constexpr std::size_t kFew = 18;  // shown without folding
  const std::size_t num_shown = order.size() <= kFew ? order.size() : 12;
  constexpr std::size_t kLong = 12;  // a shared beginning so long that it hides the rest
  const std::size_t shared = sharedPrefix(mapped(data.views, &ReportedView::image));
  const std::size_t num_alike = shared >= kLong ? shared : 0;
  for (std::size_t i = 0; i < order.size(); ++i) {
    if (i == num_shown)
      html += fmt::format("</div><details><summary>{} more views</summary><div class=\"sheet-of-views\">\n",
                          order.size() - i);
    const std::size_t v = order[i];
    const ReportedView& view = data.views[v];
    const std::string name = escapedMarkup(view.image);
    const std::string words = "RMS " + rmsText(view.rms_px);
    html += fmt::format(
        "<button class=\"thumb\" type=\"button\" data-view=\"{}\" aria-label=\"Open view {}, {}\">",
        data.first_view + v, name, words);
    html += pictures[v].empty() ? cornersPicture(data, view)
                                : fmt::format("<img alt=\"\" width=\"{}\" height=\"{}\" src=\"{}\">",
                                              data.size.width, data.size.height, pictures[v]);
    const std::string shown =
        num_alike > 0 ? "…" + escapedMarkup(std::string_view(view.image).substr(num_alike)) : name;
    html +=
        fmt::format("<span class=\"name\">{}</span><span class=\"error\">{}</span></button>\n", shown, words);
  }
  return html + (order.size() > num_shown ? "</div></details></figure>\n" : "</div></figure>\n");
}

std::string viewerHtml() {
  return std::string(kViewer);
}

}  // namespace alidade
