#include "evaluation/report/report_style.h"

namespace treeline::report {

const char* ReportStyle() {
  return R"css(
:root {
  color-scheme: light dark;
  --paper: #fbfaf6; --card: #ffffff; --ink: #1b211f; --soft: #5d6763;
  --faint: #97a09c; --rule: #e3e2db; --accent: #1f6f50; --wash: #1f6f501f;
  --truth: #2b3a55; --bad: #c4432b; --warm: #b7791f; --shadow: #1b211f0f;
  --s0: #1f6f50; --s1: #2f6fc4; --s2: #d08214; --s3: #7d4bb8; --s4: #c4432b;
  --s5: #16949c; --s6: #7a5a2f; --s7: #7d8390;
}
@media (prefers-color-scheme: dark) {
  :root {
    --paper: #12161a; --card: #191f24; --ink: #e8e6df; --soft: #a3aca8;
    --faint: #6d7773; --rule: #2b3339; --accent: #5cc296; --wash: #5cc29626;
    --truth: #9db4e0; --bad: #ff8163; --warm: #e2b25a; --shadow: #00000040;
    --s0: #5cc296; --s1: #79aef5; --s2: #f0b04e; --s3: #b9a2ff; --s4: #ff8163;
    --s5: #56cbd2; --s6: #c9a36b; --s7: #a3a9b5;
  }
}
* { box-sizing: border-box; }
html { -webkit-text-size-adjust: 100%; }
body {
  margin: 0; background: var(--paper); color: var(--ink);
  font: 16px/1.55 Inter, "Segoe UI", system-ui, -apple-system, Roboto,
        "Helvetica Neue", Arial, sans-serif;
  font-variant-numeric: tabular-nums;
}
main { max-width: 1120px; margin: 0 auto; padding: 56px 28px 72px; }
.eyebrow { color: var(--accent); font-weight: 600; font-size: 13px;
  letter-spacing: .09em; text-transform: uppercase; margin: 0 0 6px; }
h1 { font-size: 38px; line-height: 1.15; letter-spacing: -.02em;
  margin: 0 0 14px; font-weight: 680; overflow-wrap: anywhere; }
.lede { font-size: 19px; color: var(--soft); max-width: 46em; margin: 0; }
h2 { font-size: 22px; letter-spacing: -.01em; margin: 60px 0 4px;
  font-weight: 650; }
h3 { font-size: 14px; margin: 0 0 8px; color: var(--soft); font-weight: 600; }
.about { color: var(--soft); margin: 0 0 18px; max-width: 52em; }
.note { color: var(--soft); font-size: 14px; margin: 10px 0 0; }
.tiles { display: grid; gap: 14px; margin: 34px 0 0;
  grid-template-columns: repeat(auto-fit, minmax(190px, 1fr)); }
.tile, .card { background: var(--card); border: 1px solid var(--rule);
  border-radius: 12px; box-shadow: 0 1px 3px var(--shadow); }
.tile { padding: 16px 18px 14px; }
.tile b { display: block; font-size: 31px; line-height: 1.15;
  letter-spacing: -.02em; font-weight: 680; white-space: nowrap; }
.tile b small { font-size: 17px; font-weight: 600; color: var(--soft);
  letter-spacing: 0; }
.tile span { color: var(--soft); font-size: 14px; }
.card { padding: 18px 20px 12px; overflow-x: auto; }
.pair { display: grid; gap: 14px;
  grid-template-columns: repeat(auto-fit, minmax(min(440px, 100%), 1fr)); }
.chart { display: block; width: 100%; height: auto; }
.wide { min-width: 640px; }
.chart text { font-size: 12px; fill: var(--soft); }
.chart .label { font-weight: 600; }
.chart .marklabel, .chart .value { paint-order: stroke; stroke: var(--card);
  stroke-width: 4px; stroke-linejoin: round; }
.chart .value { fill: var(--ink); font-weight: 650; font-size: 13px; }
.axis, .axisline { stroke: var(--faint); stroke-width: 1; fill: none; }
.grid { stroke: var(--rule); stroke-width: 1; }
.mark { stroke: var(--faint); stroke-width: 1; stroke-dasharray: 3 4; }
.curve { fill: none; stroke: var(--accent); stroke-width: 2.2;
  stroke-linejoin: round; }
.area { fill: var(--wash); }
.knot { fill: var(--card); stroke: var(--accent); stroke-width: 2.2; }
.bar { fill: var(--accent); }
.dot.good { fill: var(--accent); fill-opacity: .75; }
.dot.bad { fill: var(--bad); }
.lost { stroke: var(--bad); stroke-width: 1.8; fill: none; }
.training { stroke: var(--faint); stroke-width: 2.6; stroke-linecap: round;
  stroke-opacity: .55; }
.truth { fill: none; stroke: var(--truth); stroke-width: 1.3;
  stroke-linejoin: round; }
.truefrustum { fill: none; stroke: var(--truth); stroke-width: .7;
  stroke-opacity: .5; }
.frustum { fill: none; stroke: var(--accent); stroke-width: .8;
  stroke-opacity: .8; }
.place { stroke: var(--accent); stroke-width: 4; stroke-linecap: round; }
.whisker { stroke: var(--accent); stroke-width: 1.2; }
.place.far, .whisker.far { stroke: var(--bad); }
.legend { display: flex; flex-wrap: wrap; gap: 4px 20px; font-size: 14px;
  color: var(--soft); margin: 6px 0 4px; padding: 0; list-style: none; }
.legend i { display: inline-block; width: 11px; height: 11px;
  border-radius: 50%; margin-right: 7px; background: var(--accent); }
.legend i.line { height: 3px; width: 18px; border-radius: 2px;
  vertical-align: middle; background: var(--truth); }
.legend i.bad { background: var(--bad); }
.legend i.gray { background: var(--faint); }
.legend i.cross { background: none; color: var(--bad); font-style: normal;
  font-weight: 700; line-height: 11px; }
.s0 { --series: var(--s0); }
.s1 { --series: var(--s1); }
.s2 { --series: var(--s2); }
.s3 { --series: var(--s3); }
.s4 { --series: var(--s4); }
.s5 { --series: var(--s5); }
.s6 { --series: var(--s6); }
.s7 { --series: var(--s7); }
.series { fill: none; stroke: var(--series); stroke-width: 2.2;
  stroke-linejoin: round; }
.series.dashed { stroke-dasharray: 6 4; }
.seriesknot { fill: var(--card); stroke: var(--series); stroke-width: 2; }
.legend i.line.s0, .legend i.line.s1, .legend i.line.s2, .legend i.line.s3,
.legend i.line.s4, .legend i.line.s5, .legend i.line.s6, .legend i.line.s7 {
  background: var(--series); }
.swatch { display: inline-block; width: 11px; height: 11px; border-radius: 3px;
  margin-right: 8px; background: var(--series); }
.after { margin-top: 14px; }
h3.sub { margin: 26px 0 8px; color: var(--ink); font-size: 16px; }
.ramp { font-size: 14px; color: var(--soft); margin: 0 0 12px; }
.ramp i { display: inline-block; width: 20px; height: 11px;
  vertical-align: middle; }
.photos.maps { margin-bottom: 22px;
  grid-template-columns: repeat(auto-fill, minmax(min(240px, 100%), 1fr)); }
img.photo { height: auto; }
.turntable svg { display: none; }
.turntable input { accent-color: var(--accent); margin: 0 4px;
  cursor: ew-resize; }
.disc { fill: var(--wash); stroke: var(--rule); stroke-width: 1; }
.turnlabel { font-size: 14px; color: var(--soft); margin-right: 8px; }
.turntable input:nth-of-type(1):checked ~ svg:nth-of-type(1),
.turntable input:nth-of-type(2):checked ~ svg:nth-of-type(2),
.turntable input:nth-of-type(3):checked ~ svg:nth-of-type(3),
.turntable input:nth-of-type(4):checked ~ svg:nth-of-type(4),
.turntable input:nth-of-type(5):checked ~ svg:nth-of-type(5),
.turntable input:nth-of-type(6):checked ~ svg:nth-of-type(6),
.turntable input:nth-of-type(7):checked ~ svg:nth-of-type(7),
.turntable input:nth-of-type(8):checked ~ svg:nth-of-type(8),
.turntable input:nth-of-type(9):checked ~ svg:nth-of-type(9),
.turntable input:nth-of-type(10):checked ~ svg:nth-of-type(10),
.turntable input:nth-of-type(11):checked ~ svg:nth-of-type(11),
.turntable input:nth-of-type(12):checked ~ svg:nth-of-type(12) { display: block; }
.frustum.far { stroke: var(--bad); }
details.method { border-top: 1px solid var(--rule); padding: 14px 0; }
details.method > summary { cursor: pointer; font-size: 17px; }
details.method > summary span { color: var(--soft); font-size: 15px; }
td.best { font-weight: 680; }
tr.group th { color: var(--soft); font-weight: 600; padding-top: 18px; }
tr.published th, tr.published td { color: var(--soft); }
tr.own th, tr.own td { color: var(--ink); }
.cards { columns: 2 420px; column-gap: 14px; }
.cards .card { break-inside: avoid; margin-bottom: 14px; }
.photos { display: grid; gap: 22px 18px;
  grid-template-columns: repeat(auto-fill, minmax(min(330px, 100%), 1fr)); }
figure { margin: 0; }
.photo { display: block; width: 100%; height: auto; border-radius: 8px;
  background: #000; }
.photo path { fill: none; stroke-linecap: round;
  stroke-width: calc(7px * var(--dot)); }
.inlier { stroke: #37e08a; stroke-opacity: .95; }
.outlier { stroke: #ff5a3c; stroke-opacity: .7; }
figcaption { font-size: 14px; color: var(--soft); padding: 8px 2px 0; }
figcaption b { color: var(--ink); font-weight: 620; }
figcaption span { color: var(--faint); }
.scroll { overflow-x: auto; }
table { border-collapse: collapse; width: 100%; font-size: 14px; }
th, td { text-align: left; padding: 7px 14px 7px 0; vertical-align: top;
  border-bottom: 1px solid var(--rule); }
tr:last-child td, tr:last-child th { border-bottom: 0; }
thead th { color: var(--soft); font-weight: 600; white-space: nowrap; }
tbody th { font-weight: 500; color: var(--soft); white-space: nowrap; }
td.n, th.n { text-align: right; white-space: nowrap; }
td { overflow-wrap: anywhere; }
td.bad { color: var(--bad); }
pre { background: var(--card); border: 1px solid var(--rule);
  border-radius: 10px; padding: 14px 18px; font-size: 13px; line-height: 1.6;
  white-space: pre-wrap; overflow-wrap: anywhere; margin: 0;
  font-family: ui-monospace, "SF Mono", "Cascadia Code", Menlo, Consolas,
               "DejaVu Sans Mono", monospace; }
footer { margin-top: 64px; color: var(--faint); font-size: 13px; }
@media print { body { background: #fff; } .card, .tile { box-shadow: none; } }
)css";
}

}  // namespace treeline::report
