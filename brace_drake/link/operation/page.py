"""A page in the browser that follows along, on this machine alone."""

from __future__ import annotations

import http.server
import json
import threading

from brace_drake.core.errors import OutputError

_PAGE = """<!doctype html><html lang="en"><meta charset="utf-8">
<meta name="viewport" content="width=device-width,initial-scale=1">
<title>Twin beside the device</title><style>
body{font:16px sans-serif;margin:2em;max-width:44em}td{padding:.1em .6em}
meter{width:18em}.alarm{color:#a00;font-weight:bold}
iframe{width:100%;height:26em;border:1px solid #999}figure{margin:1em 0}
svg{width:100%;height:8em;border:1px solid #999}
polyline{fill:none;stroke-width:1.5;vector-effect:non-scaling-stroke}
.device{stroke:#1b4f9c;color:#1b4f9c}
.twin{stroke:#c25a00;color:#c25a00;stroke-dasharray:6 3}</style>
<h1>Twin beside the device</h1><p id="state" role="status">waiting</p>
<p>contact: <b id="k"></b> N/m, <b id="c"></b> N s/m</p>
<iframe id="scene" title="Device, and its twin as a ghost, in 3D"></iframe>
<p><b class="device">device</b>, <b class="twin">twin (dashed)</b>, the last
30 s</p><div id="plots"></div>
<table><thead><tr><th>channel<th>gap, noise floors<th></thead>
<tbody id="rows"></tbody></table><script>
const at=id=>document.getElementById(id),past={},span=30;
const make=(n,e)=>e.appendChild(document.createElementNS(
"http://www.w3.org/2000/svg",n));
function figure(name){const f=document.createElement("figure"),
c=document.createElement("figcaption"),s=make("svg",f);
s.setAttribute("preserveAspectRatio","none");
const lines=["device","twin"].map(n=>{const p=make("polyline",s);
p.setAttribute("class",n);return p});
f.append(c);at("plots").append(f);return{c,s,lines,rows:[]}}
function plot(name,time,pair){const p=past[name]||(past[name]=figure(name));
p.rows.push([time,...pair]);
while(p.rows[0][0]<time-span)p.rows.shift();
const all=p.rows.flatMap(r=>[r[1],r[2]]),low=Math.min(...all),
high=Math.max(...all),room=(high-low)||1e-6;
p.s.setAttribute("viewBox","0 -0.05 1 1.1");
p.lines.forEach((l,i)=>l.setAttribute("points",p.rows.map(r=>
(1-(time-r[0])/span)+","+(high-r[i+1])/room).join(" ")));
p.c.textContent=name+": device "+pair[0].toPrecision(4)+", twin "+
pair[1].toPrecision(4)+"; shown from "+low.toPrecision(3)+" to "+
high.toPrecision(3)}
new EventSource("events").onmessage=e=>{const d=JSON.parse(e.data);
if(!d.ratio)return;
if(d.scene&&!at("scene").src)
at("scene").src="http://"+location.hostname+":"+d.scene+"/";
for(const [n,v] of Object.entries(d.signals))plot(n,d.time_s,v);
at("state").textContent=d.alarms.length?"ALARM: "+d.alarms.join(", "):
"within the band";at("state").className=d.alarms.length?"alarm":"";
at("k").textContent=d.stiffness_N_m.toFixed(0);
at("c").textContent=d.damping_N_s_m.toFixed(0);
at("rows").replaceChildren(...Object.entries(d.ratio).map(([n,v])=>{
const r=document.createElement("tr"),m=document.createElement("meter");
m.max=3*d.band;m.low=m.high=d.band;m.optimum=0;m.value=v;
for(const x of [n,m,v.toFixed(2)]){const t=document.createElement("td");
t.append(x);r.append(t)}return r}))};</script></html>"""


class Page:
    """A server of one page and its events.

    Attributes:
        url: Where it is.
    """

    def __init__(self, host: str = "127.0.0.1", port: int = 0):
        """Begins to serve.

        Args:
            host: Address to listen on; the loopback one lets nobody else in.
            port: 0 for any free one.

        Raises:
            OutputError: The address or port cannot be used.
        """
        self._news, self._text = threading.Condition(), "{}"
        self._number, self._closed = 0, False
        try:
            self._server = http.server.ThreadingHTTPServer(
                (host, port), self._MakeHandler()
            )
        except OSError as error:
            raise OutputError(f"{host}:{port}: {error.strerror}") from error
        self._server.daemon_threads = True
        self.url = "http://{}:{}/".format(*self._server.server_address[:2])
        threading.Thread(target=self._server.serve_forever, daemon=True).start()

    def Show(self, content: dict) -> None:
        """Sends new content to whoever looks."""
        with self._news:
            self._text = json.dumps(content)
            self._number += 1
            self._news.notify_all()

    def __enter__(self) -> Page:
        return self

    def __exit__(self, *_) -> None:
        self.Close()

    def Close(self) -> None:
        """Ends the server."""
        with self._news:
            self._closed = True
            self._news.notify_all()
        self._server.shutdown()
        self._server.server_close()

    def _Next(self, seen: int) -> tuple[int, str] | None:
        with self._news:
            self._news.wait_for(
                lambda: self._closed or self._number > seen, 5.0
            )
            return None if self._closed else (self._number, self._text)

    def _MakeHandler(page):
        class Handler(http.server.BaseHTTPRequestHandler):
            def do_GET(self):
                if self.path == "/":
                    self._Answer("text/html; charset=utf-8", _PAGE)
                elif self.path == "/events":
                    self._Stream()
                else:
                    self.send_error(404)

            def _Answer(self, kind, text):
                data = text.encode()
                self.send_response(200)
                self.send_header("Content-Type", kind)
                self.send_header("Content-Length", str(len(data)))
                self.end_headers()
                self.wfile.write(data)

            def _Stream(self):
                self.send_response(200)
                self.send_header("Content-Type", "text/event-stream")
                self.end_headers()
                seen = 0
                try:
                    while (found := page._Next(seen)) is not None:
                        seen, text = found
                        self.wfile.write(f"data: {text}\n\n".encode())
                except OSError:
                    return

            def log_message(self, *_):
                pass

        return Handler
