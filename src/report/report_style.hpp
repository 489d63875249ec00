#pragma once

#include <string_view>

namespace loopstone {

/// The report's style sheet: light and dark by the reader's setting, always light on paper.
inline constexpr std::string_view kReportStyle = R"css(
:root { color-scheme: light dark; --ink: #1f2937; --soft: #5b6675; --ground: #ffffff; --card: #f5f6f8; --line: #d8dde5;
  --a: #1d4ed8; --b: #ea580c; --c: #7c3aed; --good: #047857; --bad: #b91c1c; --warn-ground: #fef3c7; --warn-ink: #78350f;
  --tracking: #0072b2; --doubtful: #e69f00; --lost: #b0004e; --tint: .13; }
@media (prefers-color-scheme: dark) { :root { --ink: #e5e7eb; --soft: #9aa5b4; --ground: #14181f; --card: #1d232c;
  --line: #343d4a; --a: #7aa2ff; --b: #fb923c; --c: #c4a5ff; --good: #34d399; --bad: #f87171; --warn-ground: #3b2f10; --warn-ink: #fde68a;
  --tracking: #3ba0e6; --doubtful: #f2b233; --lost: #ff5c9e; --tint: .2; } }
* { box-sizing: border-box; }
body { margin: 0 auto; padding: 2rem 1.25rem 4rem; max-width: 62rem; background: var(--ground); color: var(--ink);
  font: 16px/1.5 system-ui, -apple-system, "Segoe UI", Roboto, "DejaVu Sans", sans-serif; }
h1 { font-size: 1.6rem; line-height: 1.25; margin: 0 0 .25rem; overflow-wrap: anywhere; }
h2 { font-size: 1.15rem; margin: 2.5rem 0 .75rem; padding-bottom: .25rem; border-bottom: 1px solid var(--line); }
p { margin: .5rem 0; }
.verdict { font-size: 1.1rem; }
.soft { color: var(--soft); font-size: .9rem; overflow-wrap: anywhere; }
.warnings { background: var(--warn-ground); color: var(--warn-ink); border-radius: .5rem; padding: .75rem 1rem; margin: 1rem 0; }
.warnings ul { margin: .25rem 0 0; padding-left: 1.25rem; }
img.map { display: block; max-width: 100%; max-height: 90vh; margin: 0 auto; border: 1px solid var(--line); border-radius: .5rem; background: #fff; }
figure { margin: 1rem 0; }
figcaption { color: var(--soft); font-size: .9rem; margin-top: .35rem; }
.figures { display: grid; grid-template-columns: repeat(auto-fit, minmax(min(24rem, 100%), 1fr)); gap: .5rem 1.5rem; align-items: start; }
.figures table { background: var(--card); border-radius: .5rem; }
table { border-collapse: collapse; width: 100%; font-size: .93rem; }
caption { text-align: left; font-weight: 600; padding: .6rem .75rem .3rem; }
th, td { padding: .3rem .75rem; text-align: left; vertical-align: top; font-weight: normal; }
td.n, th.n { text-align: right; font-variant-numeric: tabular-nums; white-space: nowrap; }
table.list th { font-weight: 600; border-bottom: 1px solid var(--line); }
table.list td { border-bottom: 1px solid var(--line); }
.scroll { overflow-x: auto; }
.good { color: var(--good); } .bad { color: var(--bad); }
details { margin: .75rem 0; } summary { cursor: pointer; color: var(--soft); }
pre { background: var(--card); border-radius: .5rem; padding: .75rem 1rem; overflow-x: auto; font-size: .83rem; line-height: 1.4; }
svg.plot { display: block; width: 100%; height: auto; font-size: 12px; }
svg.plot text { fill: var(--soft); } svg.plot path { fill: none; }
svg.plot .grid { stroke: var(--line); stroke-width: 1; } svg.plot .axis { stroke: var(--soft); stroke-width: 1; }
svg.plot .curve { stroke-width: 1.6; stroke-linejoin: round; stroke-linecap: round; }
svg.plot .curve.a { stroke: var(--a); } svg.plot .curve.b { stroke: var(--b); } svg.plot .curve.c { stroke: var(--c); }
.tracking { fill: var(--tracking); } .doubtful { fill: var(--doubtful); } .lost { fill: var(--lost); } svg.plot .band { opacity: var(--tint); } svg.plot .band.tracking { opacity: .04; }
.state { display: inline-block; border-radius: .3rem; padding: 0 .45rem; font-size: .85rem; font-weight: 600; color: #fff; white-space: nowrap; }
.state.tracking { background: #0072b2; } .state.doubtful { background: #e69f00; color: #1f2937; } .state.lost { background: #b0004e; } .state.unknown { background: #6b7280; }
.gallery { display: grid; grid-template-columns: repeat(auto-fill, minmax(min(18rem, 100%), 1fr)); gap: 1rem; }
.gallery figure { margin: 0; } .gallery img { display: block; width: 100%; border: 1px solid var(--line); border-radius: .4rem; }
@media print { :root { color-scheme: light; --ink: #000; --soft: #444; --ground: #fff; --card: #f5f6f8; --line: #ccc; --a: #1d4ed8;
  --b: #ea580c; --c: #7c3aed; --good: #047857; --bad: #b91c1c; --warn-ground: #fff; --warn-ink: #000; --tracking: #0072b2; --doubtful: #e69f00;
  --lost: #b0004e; --tint: .13; }
  body { max-width: none; padding: 0; font-size: 11px; } h2 { break-after: avoid; } figure, table.key { break-inside: avoid; }
  img.map { max-height: 20cm; } .warnings { border: 1px solid var(--line); } }
)css";

}  // namespace loopstone
