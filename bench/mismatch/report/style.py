"""How the page looks, light and dark."""

STYLE = """
:root{color-scheme:light dark;--ink:#1d2126;--dim:#5c6670;--paper:#fff;--line:#d8dde2;--box:#f4f6f8;--good:#1a7f45;
--bad:#b3420f;--open:#7a5a00}
@media(prefers-color-scheme:dark){:root{--ink:#e3e7eb;--dim:#9aa5af;--paper:#14171a;--line:#343b42;--box:#1e2327;
--good:#5fc98b;--bad:#f08a57;--open:#e0bb4e}}
*{box-sizing:border-box}body{font:16px/1.5 system-ui,sans-serif;max-width:58rem;margin:0 auto;padding:1.5rem 1rem 3rem;
color:var(--ink);background:var(--paper)}
h1{font-size:1.1rem;font-weight:600;color:var(--dim);margin:0 0 .6rem}h2{font-size:1.15rem;margin:0}
h3{font-size:.8rem;text-transform:uppercase;letter-spacing:.05em;color:var(--dim);margin:1.1rem 0 .3rem}
.verdict{font-size:1.3rem;line-height:1.4;border-left:.35rem solid var(--tone);padding:.2rem 0 .2rem 1rem;
margin:0 0 1.6rem}
.verdict b{color:var(--tone)}.match{--tone:var(--good)}.mismatch{--tone:var(--bad)}.undetermined{--tone:var(--open)}
article{border:1px solid var(--line);border-radius:.5rem;padding:1.1rem 1.3rem;margin:1.4rem 0}
.head{display:flex;flex-wrap:wrap;gap:.6rem;align-items:baseline}.tag{font-size:.8rem;border:1px solid currentColor;
border-radius:1rem;padding:0 .6rem;white-space:nowrap}.named{color:var(--good)}.ambiguous{color:var(--open)}
.unknown{color:var(--bad)}.dim{color:var(--dim)}p{margin:.4rem 0}table{border-collapse:collapse;font-size:.92rem}
td,th{border-bottom:1px solid var(--line);padding:.25rem .9rem .25rem 0;text-align:left;vertical-align:top}
th{font-weight:600;color:var(--dim)}td.n{font-variant-numeric:tabular-nums;text-align:right}
code{font:.95em ui-monospace,monospace;background:var(--box);padding:.15rem .45rem;border-radius:.25rem;
overflow-wrap:anywhere}svg{max-width:100%;height:auto;color:var(--ink);margin:.5rem 0}
figure{margin:0}.equation{font-size:1.15rem;overflow-x:auto}dl{margin:.3rem 0}dt{float:left;clear:left;min-width:4.5rem}
dd{margin-left:5rem}.verdict p{margin:.2rem 0}.verdict p+p{font-size:1.05rem;color:var(--ink)}
ul{margin:.3rem 0;padding-left:1.2rem}
.wide{overflow-x:auto}.tall{max-height:26rem;overflow-y:auto}
"""
