// SPDX-License-Identifier: MIT
// Starts the page, and shows the part that the address names.

import { get, prepareSignIn } from "./api.js";
import { prepareCompare } from "./compare.js";
import { prepareDecisions, showDecisions } from "./decisions.js";
import { byId, counted, say } from "./dom.js";
import { prepareDuplicates, showDuplicates } from "./duplicates.js";
import { prepareMap, showMap } from "./map.js";
import { prepareSearch } from "./search.js";
import { state } from "./state.js";

const PARTS = { search: () => {}, duplicates: showDuplicates, map: showMap, decisions: showDecisions };

let shown = null;

// Returns whether it is another part than before.
function showPart() {
  const before = shown;
  const name = location.hash.slice(1) in PARTS ? location.hash.slice(1) : "search";
  for (const other of Object.keys(PARTS)) byId(other).hidden = other !== name;
  for (const link of document.querySelectorAll("nav a")) {
    if (link.hash === `#${name}`) link.setAttribute("aria-current", "page");
    else link.removeAttribute("aria-current");
  }
  shown = name;
  PARTS[name]();
  return name !== before;
}

async function start() {
  prepareSignIn();
  try {
    const session = await get("session");
    state.scope = session.scope;
    state.needsToken = session.needs_token;
    state.info = await get("info");
    say(byId("library"), `${state.info.library}: ${counted(state.info.shapes, "shape")}`);
    document.title = `${state.info.library} – Shape Google`;
  } catch (error) {
    say(byId("library"), error.message, true);
    if (error.status === 401) return;
  }
  prepareCompare();
  prepareSearch();
  prepareDuplicates();
  prepareMap();
  prepareDecisions();
  addEventListener("hashchange", () => {
    if (showPart()) byId("content").focus();
  });
  showPart();
}

start();
