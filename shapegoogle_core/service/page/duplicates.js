// SPDX-License-Identifier: MIT
// Groups of duplicates, and the decisions about them.

import { patiently, post, thumbnail } from "./api.js";
import { closeDialog, compare } from "./compare.js";
import { byId, counted, make, picture, place, say, title } from "./dom.js";
import { searchFor } from "./search.js";
import { author, state } from "./state.js";
import { percent } from "./words.js";

let next = null;
let shown = 0;
let asked = 0;

export function prepareDuplicates() {
  byId("more-groups").addEventListener("click", () => load(next));
}

export async function showDuplicates() {
  byId("groups").replaceChildren();
  shown = 0;
  await load(0);
}

async function load(offset) {
  asked += 1;
  const mine = asked;
  const status = byId("duplicates-state");
  say(status, "Looking for duplicates…");
  byId("more-groups").hidden = true;
  try {
    const answer = await patiently(`duplicates?offset=${offset}&limit=20`, () => say(status, "Looking for duplicates; this takes a while in a large library…"));
    if (mine !== asked) return;
    byId("groups").append(...answer.groups.map(group));
    shown += answer.groups.length;
    next = answer.next;
    byId("more-groups").hidden = next === null;
    say(status, answer.total ? `${counted(answer.total, "group")}, the largest saving first.` : "There are no duplicates.");
  } catch (error) {
    say(status, error.message, true);
  }
}

function group(found) {
  const [first] = found.members;
  const noun = found.kind === "copies" ? "file" : "shape";
  const heading = `${found.title}: ${counted(found.members.length, noun)}; ${counted(found.saving.faces, "face")} besides the first`;
  const cards = found.members.map((member, index) => card(member, index ? first : null));
  return make("li", {}, make("h3", {}, heading), make("ol", { class: "gallery" }, ...cards));
}

function card(member, first) {
  const named = { shape_id: member.shape_id, name: title(member) };
  const actions = () => [
    { label: "Search for this", run: async () => { closeDialog(); await searchFor(member); } },
  ];
  const open = () => compare(member, { examples: first ? [{ shape_id: first.shape_id, name: title(first) }] : [], actions: actions() });
  const figures = first ? `same shape ${percent(member.similarity)}, ×${Number(member.scale.toPrecision(3))}` : "first of the group";
  const text = make("span", { class: "text" }, make("span", { class: "name" }, title(member)), make("small", {}, place(member.source)), make("small", {}, figures));
  const row = make("span", { class: "row" });
  if (first && state.scope === "write") {
    row.append(
      button("Keep both", { kind: "keep both", shape: { shape_id: first.shape_id }, other: member.shape_id }),
      button("Make master", { kind: "master", shape: { shape_id: named.shape_id } }),
    );
  }
  return make("li", { class: "card" }, make("button", { type: "button", class: "open", onclick: open }, picture(thumbnail(member), ""), text), row);
}

function button(label, decision) {
  const run = async () => {
    try {
      await post("decisions", { ...decision, author: author() });
      await showDuplicates();
    } catch (error) {
      say(byId("duplicates-state"), error.message, true);
    }
  };
  return make("button", { type: "button", onclick: run }, label);
}
