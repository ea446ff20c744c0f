// SPDX-License-Identifier: MIT
// Searching: examples, filters, and the gallery of matches.

import { get, post, thumbnail, upload } from "./api.js";
import { closeDialog, compare } from "./compare.js";
import { byId, counted, make, picture, place, say, title } from "./dom.js";
import { author, state } from "./state.js";
import { figures, isWeak, KINDS, kindText, TYPES } from "./words.js";

const PAGE = 24;
const EVIDENCE = 10;
let like = [];
let unlike = [];
let query = null;
let next = null;
let shownCount = 0;
let running = 0;
let foundFor = "";
let entered = null;

export function prepareSearch() {
  const { kind, shape_type: type } = byId("filters").querySelector("form").elements;
  kind.append(...KINDS.map((name) => make("option", { value: name }, name)));
  type.append(...TYPES.map((name) => make("option", { value: name }, name)));
  byId("filters").querySelector("form").addEventListener("submit", (event) => {
    event.preventDefault();
    search();
  });
  byId("filters").querySelector("form").addEventListener("reset", () => setTimeout(search));
  byId("more").addEventListener("click", showMore);
  prepareUpload();
  prepareFind();
}

function prepareUpload() {
  const drop = byId("drop");
  byId("formats").textContent = state.info ? state.info.formats.join(" ") : "";
  byId("file").accept = state.info ? state.info.formats.join(",") : "";
  byId("file").addEventListener("change", (event) => {
    const [file] = event.target.files;
    event.target.value = "";
    if (file) useFile(file);
  });
  for (const kind of ["dragenter", "dragover"]) {
    document.addEventListener(kind, (event) => {
      if (![...event.dataTransfer.types].includes("Files")) return;
      event.preventDefault();
      drop.classList.add("over");
    });
  }
  document.addEventListener("dragleave", (event) => {
    if (!event.relatedTarget) drop.classList.remove("over");
  });
  document.addEventListener("drop", (event) => {
    drop.classList.remove("over");
    const [file] = event.dataTransfer.files;
    if (!file) return;
    event.preventDefault();
    location.hash = "search";
    useFile(file);
  });
}

async function useFile(file) {
  if (state.info && file.size > state.info.max_upload) {
    say(byId("state"), `${file.name} is larger than ${Math.round(state.info.max_upload / 2 ** 20)} MB; simplify it.`, true);
    return;
  }
  say(byId("state"), `Reading ${file.name}…`);
  try {
    const answer = await upload(file);
    const shapes = answer.shapes.map((shape) => ({ upload: answer.upload, index: shape.index, name: title(shape), note: file.name }));
    // A file of several shapes lets choose one; the first is searched at once.
    byId("found").replaceChildren(...(shapes.length > 1 ? shapes.map((shape) => choice(shape, () => searchWith(shape))) : []));
    await searchWith(shapes[0]);
    if (answer.problems.length) say(byId("state"), `${byId("state").textContent} ${answer.problems.join(" ")}`);
  } catch (error) {
    say(byId("state"), error.message, true);
  }
}

function prepareFind() {
  let last = 0;
  let waiting = 0;
  byId("find").addEventListener("input", (event) => {
    clearTimeout(waiting);
    const text = event.target.value.trim();
    entered = null;
    last += 1;
    const mine = last;
    waiting = setTimeout(async () => {
      try {
        const answer = text ? await get(`shapes?limit=20&search=${encodeURIComponent(text)}`) : { shapes: [] };
        if (mine !== last) return;
        byId("found").replaceChildren(...answer.shapes.map(foundShape));
        foundFor = text;
        if (entered === text) takeFirst();
        if (text && !answer.shapes.length) byId("found").append(make("li", { class: "hint" }, "No shape of this name."));
      } catch (error) {
        say(byId("state"), error.message, true);
      }
    }, 200);
  });
  byId("find").addEventListener("keydown", (event) => {
    if (event.isComposing) return;
    if (event.key === "Enter") {
      // What was found for an earlier text is not taken; the shapes for this one may still be under way.
      entered = event.target.value.trim();
      if (entered === foundFor) takeFirst();
    } else if (event.key === "ArrowDown") {
      event.preventDefault();
      byId("found").querySelector("button")?.focus();
    }
  });
  byId("found").addEventListener("keydown", (event) => {
    const step = { ArrowDown: 1, ArrowUp: -1 }[event.key];
    if (!step) return;
    event.preventDefault();
    const choices = [byId("find"), ...byId("found").querySelectorAll("button")];
    choices[choices.indexOf(document.activeElement) + step]?.focus();
  });
}

function takeFirst() {
  entered = null;
  byId("found").querySelector("button")?.click();
}

function foundShape(shape) {
  const use = () => {
    byId("found").replaceChildren();
    byId("find").value = "";
    searchFor(shape);
    byId("find").focus(); // after the address has changed, which takes the focus away
  };
  return choice({ shape_id: shape.shape_id, name: title(shape), note: place(shape.source) }, use);
}

function choice(example, use) {
  const text = make("span", {}, example.name, make("small", {}, example.note));
  return make("li", {}, make("button", { type: "button", onclick: use }, picture(thumbnail(example), ""), text));
}

// Search for one shape, instead of what was searched before.
function searchWith(example) {
  like = [example];
  unlike = [];
  location.hash = "search";
  return search();
}

export const searchFor = (shape) => searchWith({ shape_id: shape.shape_id, name: title(shape) });

function addExample(list, shape) {
  const example = { shape_id: shape.shape_id, name: title(shape) };
  like = like.filter((other) => other.shape_id !== shape.shape_id);
  unlike = unlike.filter((other) => other.shape_id !== shape.shape_id);
  if (list === "like") like.push(example);
  else unlike.push(example);
  search();
  scrollTo({ top: 0, behavior: "smooth" });
}

function showExamples() {
  const chip = (example, list) => {
    const remove = () => {
      like = like.filter((other) => other !== example);
      unlike = unlike.filter((other) => other !== example);
      search();
    };
    const label = list === "like" ? "like this" : "not like this";
    return make(
      "li",
      { class: list },
      picture(thumbnail(example), ""),
      make("span", {}, example.name, make("small", {}, label)),
      make("button", { type: "button", "aria-label": `Remove ${example.name}`, onclick: remove }, "✕"),
    );
  };
  byId("examples").replaceChildren(...like.map((one) => chip(one, "like")), ...unlike.map((one) => chip(one, "unlike")));
}

function conditions() {
  const { elements } = byId("filters").querySelector("form");
  const where = {};
  for (const name of ["text", "tag", "file_type", "kind", "shape_type", "catalog"]) if (elements[name].value.trim()) where[name] = elements[name].value.trim();
  const number = (name) => (elements[name].value === "" ? null : Number(elements[name].value));
  if (number("faces_low") !== null || number("faces_high") !== null) where.faces = [number("faces_low"), number("faces_high")];
  if (number("min_similarity") !== null) where.min_similarity = number("min_similarity") / 100;
  return { where, rank: elements.rank.value, families: elements.families.checked };
}

const reference = ({ shape_id, upload: name, index }) => (name ? { upload: name, index } : { shape_id });

async function search() {
  running += 1;
  const mine = running;
  showExamples();
  byId("more").hidden = true;
  if (!like.length) {
    byId("matches").replaceChildren();
    say(byId("state"), unlike.length ? "Add an example of what you search." : "");
    return;
  }
  say(byId("state"), "Searching…");
  try {
    const request = { like: like.map(reference), unlike: unlike.map(reference), limit: PAGE, evidence: EVIDENCE, ...conditions() };
    const page = await post("queries", request);
    if (mine !== running) return;
    query = page.query;
    byId("matches").replaceChildren();
    shownCount = 0;
    append(page);
  } catch (error) {
    if (mine !== running) return;
    byId("matches").replaceChildren();
    say(byId("state"), error.message, true);
  }
}

async function showMore() {
  byId("more").disabled = true;
  const mine = running;
  try {
    const page = await get(`queries/${query}?offset=${next}&limit=${PAGE}&evidence=${EVIDENCE}`);
    if (mine === running) append(page);
  } catch (error) {
    say(byId("state"), error.message, true);
  } finally {
    byId("more").disabled = false;
  }
}

function append(page) {
  const cards = page.matches.map((match) => card(match));
  for (const tag of page.matches.flatMap((match) => match.tags)) offerTag(tag);
  byId("matches").append(...cards);
  shownCount += page.matches.length;
  next = page.next;
  byId("more").hidden = next === null;
  const number = next === null ? counted(shownCount, "match").replace("matchs", "matches") : `the best ${shownCount} matches`;
  say(byId("state"), shownCount ? `${number.charAt(0).toUpperCase()}${number.slice(1)}.` : "No shape meets the filters.");
  if (page.offset && cards.length) cards[0].querySelector("button").focus();
}

// Tags that were seen are offered where one is typed.
function offerTag(tag) {
  const offered = [...byId("tags").options];
  if (!offered.some((option) => option.value === tag)) byId("tags").append(make("option", { value: tag }));
}

function card(match, version = false) {
  const element = make("li", { class: version ? "card version" : "card" });
  const evidence = kindText(match.evidence);
  element.dataset.shape = match.shape_id;
  const actions = () => matchActions(match);
  const open = () => compare(match, { examples: like, match, actions: actions() });
  const text = make(
    "span",
    { class: "text" },
    make("span", { class: "name" }, title(match)),
    evidence ? make("span", { class: isWeak(match.evidence) ? "kind weak" : "kind" }, evidence) : null,
    make("small", {}, figures(match)),
  );
  const row = make(
    "span",
    { class: "row" },
    make("button", { type: "button", title: "More like this", "aria-label": `More like ${title(match)}`, onclick: () => addExample("like", match) }, "+ like"),
    make("button", { type: "button", title: "Not like this", "aria-label": `Not like ${title(match)}`, onclick: () => addExample("unlike", match) }, "− unlike"),
  );
  if (match.versions && !version) {
    row.append(make("button", { type: "button", onclick: (event) => showVersions(match, element, event.target) }, counted(match.versions, "version")));
  }
  element.append(make("button", { type: "button", class: "open", onclick: open }, picture(thumbnail(match), ""), text), row);
  return element;
}

async function showVersions(match, element, button) {
  button.disabled = true;
  try {
    const page = await get(`queries/${query}/versions/${match.shape_id}`);
    element.after(...page.matches.filter((other) => other.shape_id !== match.shape_id).map((other) => card(other, true)));
  } catch (error) {
    button.disabled = false;
    say(byId("state"), error.message, true);
  }
}

function matchActions(match) {
  const again = { label: "Search for this", run: async () => { closeDialog(); await searchFor(match); } };
  if (state.scope !== "write" || like.some((example) => example.shape_id === match.shape_id)) return [again];
  const refuse = async () => {
    for (const example of like) {
      await post("decisions", { kind: "not a match", shape: reference(example), other: match.shape_id, author: author() });
    }
    byId("matches").querySelector(`[data-shape="${match.shape_id}"]`)?.remove();
    closeDialog();
    say(byId("state"), `${title(match)} is hidden from this search from now on; undo it under Decisions.`);
  };
  return [again, { label: "Not a match", run: refuse }];
}
