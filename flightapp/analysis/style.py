"""The look of the report."""

STYLE = """
:root { color-scheme: light; }
* { box-sizing: border-box; }
body { margin: 0; background: #f5f7fa; color: #1f2933;
  font: 14px/1.45 system-ui, -apple-system, "Segoe UI", Roboto, Arial, sans-serif; }
main { max-width: 1320px; margin: 0 auto; padding: 28px 24px 60px; }
h1 { margin: 0; font-size: 26px; letter-spacing: -0.01em; }
h2 { margin: 0 0 10px; font-size: 17px; }
h3 { margin: 0 0 2px; font-size: 14px; font-weight: 600; }
.sub, .note { color: #52606d; margin: 4px 0 0; }
.note { margin: 0 0 8px; }
section { background: #fff; border: 1px solid #e4e7eb; border-radius: 8px; padding: 16px 18px; margin-top: 16px; }
.verdict { margin-top: 16px; padding: 14px 18px; border-radius: 8px; font-size: 16px; border-left: 6px solid; }
.verdict ul { margin: 6px 0 0; padding-left: 20px; font-size: 14px; }
.verdict.good { background: #e7f6ec; border-color: #1a7f43; }
.verdict.attention { background: #fff5e0; border-color: #c77700; }
.verdict.bad { background: #fdeceb; border-color: #b42318; }
.columns { display: grid; grid-template-columns: minmax(380px, 5fr) minmax(0, 7fr); gap: 16px; align-items: start; }
.columns > section { overflow-x: auto; }
.charts { display: grid; grid-template-columns: 1fr 1fr; gap: 12px 20px; }
section.chart { border: 0; padding: 0; margin: 0; min-width: 0; }
table { border-collapse: collapse; width: 100%; font-variant-numeric: tabular-nums; }
th, td { text-align: left; padding: 5px 10px 5px 0; border-bottom: 1px solid #edf0f3; vertical-align: top; }
th { color: #52606d; font-weight: 600; white-space: nowrap; border-bottom-color: #cbd2d9; }
table.figures td:first-child, table.vehicles td:first-child { color: #52606d; }
table.figures td:last-child { text-align: right; padding-right: 0; white-space: nowrap; }
table.vehicles td, table.events td:first-child { white-space: nowrap; }
.scroll { max-height: 560px; overflow-y: auto; }
.scroll th { position: sticky; top: 0; background: #fff; }
.badge { display: inline-block; min-width: 62px; padding: 0 8px; border-radius: 9px; font-size: 12px; text-align: center;
  background: #e4e7eb; }
.badge.warning { background: #ffe3ad; }
.badge.error { background: #f9c5c0; }
.badge.phase { background: #d6e8f7; }
@media (max-width: 1000px) { .columns, .charts { grid-template-columns: 1fr; } }
@media print { body { background: #fff; } section { break-inside: avoid; } .scroll { max-height: none; overflow: visible; } }
"""
