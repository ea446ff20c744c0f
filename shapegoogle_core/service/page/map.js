// SPDX-License-Identifier: MIT
// The map: pictures of shapes in the plane. It is moved by scrolling, so touch and keyboard work as usual.

import { patiently, thumbnail } from "./api.js";
import { closeDialog, compare } from "./compare.js";
import { byId, make, picture, say } from "./dom.js";
import { searchFor } from "./search.js";

// Half a picture, so that none is cut off at the edge.
const MARGIN = 2;
let zoom = 1;
let loaded = false;

export function prepareMap() {
  byId("zoom-in").addEventListener("click", () => resize(zoom * 1.5));
  byId("zoom-out").addEventListener("click", () => resize(zoom / 1.5));
  byId("plane").addEventListener("wheel", (event) => {
    if (!event.ctrlKey) return;
    event.preventDefault();
    resize(zoom * (event.deltaY < 0 ? 1.15 : 1 / 1.15));
  }, { passive: false });
}

export async function showMap() {
  const status = byId("map-state");
  if (loaded) return;
  say(status, "Drawing the map…");
  try {
    const answer = await patiently("map", () => say(status, "Drawing the map; this takes a while in a large library…"));
    loaded = true;
    const { points, total } = answer;
    byId("points").replaceChildren(...points.map(point));
    resize(Math.max(1, Math.sqrt(points.length / 60)));
    const part = points.length < total ? ` of ${total.toLocaleString("en")}, evenly chosen` : "";
    say(status, total ? `${points.length.toLocaleString("en")} shapes${part}.` : "The library has no shapes.");
  } catch (error) {
    say(status, error.message, true);
  }
}

function point({ shape_id, name, x, y }) {
  const shape = { shape_id, name, object_name: "" };
  const actions = [{ label: "Search for this", run: async () => { closeDialog(); await searchFor(shape); } }];
  const button = make("button", { type: "button", title: name, onclick: () => compare(shape, { actions }) }, picture(thumbnail(shape), name));
  button.style.left = `calc(${MARGIN}rem + ${x} * (100% - ${2 * MARGIN}rem))`;
  button.style.top = `calc(${MARGIN}rem + ${y} * (100% - ${2 * MARGIN}rem))`;
  return button;
}

// The middle of what is seen stays where it is.
function resize(wanted) {
  const plane = byId("plane");
  const x = (plane.scrollLeft + plane.clientWidth / 2) / plane.scrollWidth;
  const y = (plane.scrollTop + plane.clientHeight / 2) / plane.scrollHeight;
  zoom = Math.min(Math.max(wanted, 1), 12);
  byId("points").style.width = `${100 * zoom}%`;
  byId("points").style.height = `${100 * zoom}%`;
  plane.scrollLeft = x * plane.scrollWidth - plane.clientWidth / 2;
  plane.scrollTop = y * plane.scrollHeight - plane.clientHeight / 2;
}
