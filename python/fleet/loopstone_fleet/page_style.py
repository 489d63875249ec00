"""The style sheet of the fleet's page: light and dark as the report of a single map."""

STYLE = """
:root { color-scheme: light dark; --ink: #1f2937; --soft: #5b6675; --ground: #ffffff;
  --card: #f5f6f8; --line: #d8dde5; --a: #1d4ed8; --good: #047857; --doubtful: #e69f00;
  --bad: #b91c1c; --unknown: #6b7280; --none: #1f2937; }
@media (prefers-color-scheme: dark) { :root { --ink: #e5e7eb; --soft: #9aa5b4; --ground: #14181f;
  --card: #1d232c; --line: #343d4a; --a: #7aa2ff; --good: #34d399; --doubtful: #f2b233;
  --bad: #f87171; --unknown: #9aa5b4; --none: #d8dde5; } }
* { box-sizing: border-box; }
body { margin: 0 auto; padding: 2rem 1.25rem 4rem; max-width: 70rem; background: var(--ground);
  color: var(--ink);
  font: 16px/1.5 system-ui, -apple-system, "Segoe UI", Roboto, "DejaVu Sans", sans-serif; }
h1 { font-size: 1.6rem; line-height: 1.25; margin: 0 0 .25rem; }
h2 { font-size: 1.15rem; margin: 2.5rem 0 .75rem; padding-bottom: .25rem;
  border-bottom: 1px solid var(--line); }
p { margin: .5rem 0; }
a { color: var(--a); text-decoration: none; } a:hover { text-decoration: underline; }
.verdict { font-size: 1.1rem; }
.soft { color: var(--soft); font-size: .9rem; overflow-wrap: anywhere; }
.bar { display: flex; height: 1.5rem; border-radius: .5rem; overflow: hidden; gap: 2px;
  margin: 1rem 0 .5rem; }
.bar span { min-width: 3px; }
.key { display: flex; flex-wrap: wrap; gap: .25rem 1.25rem; font-size: .93rem; }
.key i { display: inline-block; width: .8rem; height: .8rem; border-radius: .2rem;
  margin-right: .4rem; vertical-align: -.05rem; }
.bg-good { background: var(--good); } .bg-doubtful { background: var(--doubtful); }
.bg-bad { background: var(--bad); } .bg-unknown { background: var(--unknown); }
.bg-none { background: var(--none); }
.figures { display: grid; grid-template-columns: repeat(auto-fit, minmax(9.5rem, 1fr));
  gap: .75rem; margin: 1.25rem 0; }
.figures div { background: var(--card); border-radius: .5rem; padding: .6rem .85rem; }
.figures b { display: block; font-size: 1.25rem; font-weight: 600;
  font-variant-numeric: tabular-nums; }
.figures span { color: var(--soft); font-size: .85rem; }
table { border-collapse: collapse; width: 100%; font-size: .93rem; }
th, td { padding: .35rem .75rem .35rem 0; text-align: left; vertical-align: top;
  border-bottom: 1px solid var(--line); }
th { font-weight: 600; }
td.n, th.n { text-align: right; font-variant-numeric: tabular-nums; white-space: nowrap; }
td.log { overflow-wrap: anywhere; min-width: 10rem; }
td.robot { white-space: nowrap; }
.state { display: inline-block; border-radius: .3rem; padding: 0 .5rem; font-size: .85rem;
  font-weight: 600; color: #fff; background: #6b7280; white-space: nowrap; }
.state.good, .state.fine, .state.joined { background: #047857; }
.state.doubtful, .state.watch, .state.pending { background: #e69f00; color: #1f2937; }
.state.bad, .state.service, .state.failed { background: #b91c1c; }
.gallery { display: grid; grid-template-columns: repeat(auto-fill, minmax(min(16rem, 100%), 1fr));
  gap: 1rem; margin-top: 1.25rem; }
figure { margin: 0; }
.gallery img { display: block; width: 100%; height: 12rem; object-fit: contain; background: #fff;
  border: 1px solid var(--line); border-radius: .4rem; }
figcaption { color: var(--soft); font-size: .85rem; margin-top: .35rem; overflow-wrap: anywhere; }
@media (max-width: 40rem) {
  body { padding: 1.25rem 1rem 3rem; }
  thead { display: none; }
  tr { display: block; padding: .5rem 0; border-bottom: 1px solid var(--line); }
  td, td.n { display: flex; gap: .75rem; padding: .12rem 0; border: 0; text-align: left;
    white-space: normal; }
  td:empty { display: none; }
  td::before { content: attr(data-name); color: var(--soft); flex: 0 0 6.5rem; }
  td.log { min-width: 0; font-weight: 600; } td.log::before { display: none; }
}
@media print { :root { color-scheme: light; --ink: #000; --soft: #444; --ground: #fff;
  --card: #f5f6f8; --line: #ccc; } body { max-width: none; padding: 0; font-size: 11px; } }
"""
