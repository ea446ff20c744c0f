// SPDX-License-Identifier: MIT
// The dialog that shows a shape, beside the query where there is one, with what can be done with it.

import { bytes, get, post, preview } from "./api.js";
import { byId, make, place, say, title } from "./dom.js";
import { author, state } from "./state.js";
import { figures, kindText } from "./words.js";

let end = null;
let shown = null;

// `examples`: those of the query; `actions`: further buttons.
export async function compare(shape, { examples = [], match = null, actions = [] } = {}) {
  const dialog = byId("compare");
  close();
  const session = {};
  shown = session;
  byId("compare-title").textContent = title(shape);
  say(byId("compare-state"), "");
  byId("facts").replaceChildren();
  byId("actions").replaceChildren();
  // Until the shape is described, a tag would go to the shape that was shown before.
  byId("tagging").hidden = true;
  if (!dialog.open) dialog.showModal();
  const both = [...examples.slice(0, 1).map((example) => ({ example, label: `Query: ${example.name}` })), { example: shape, label: title(shape) }];
  const figuresOf = both.map(({ label }) => {
    const stage = make("div", { class: "stage" }, "Loading…");
    return { stage, element: make("figure", {}, stage, make("figcaption", {}, label)) };
  });
  const viewers = byId("viewers");
  viewers.classList.toggle("single", both.length === 1);
  viewers.replaceChildren(...figuresOf.map(({ element }) => element));
  describe(shape, match, actions).catch((error) => say(byId("compare-state"), error.message, true));
  const stages = [];
  const loaded = both.map(async ({ example, label }, index) => {
    const { readPreview } = await import("./viewer.js");
    stages[index] = { stage: figuresOf[index].stage, preview: await readPreview(await bytes(preview(example))), label };
  });
  const outcomes = await Promise.allSettled(loaded);
  if (shown !== session) return;
  outcomes.forEach((outcome, index) => {
    if (outcome.status === "rejected") figuresOf[index].stage.textContent = outcome.reason.message;
  });
  try {
    const { show } = await import("./viewer.js");
    if (shown !== session) return;
    end = show(stages.filter(Boolean));
  } catch {
    for (const { stage } of figuresOf) stage.textContent = "This browser shows no 3-D pictures (WebGL is off).";
  }
}

async function describe(shape, match, actions) {
  const session = shown;
  const details = await get(`shapes/${shape.shape_id}`);
  if (shown !== session) return;
  const facts = [["From", place(details.source)], ["Size", details.extents.map((extent) => Number(extent.toPrecision(3))).join(" × ")]];
  facts.push(["Mesh", `${details.vertices.toLocaleString("en")} vertices, ${details.faces.toLocaleString("en")} faces`]);
  if (details.catalog) facts.push(["Catalog", details.catalog]);
  if (details.placements > 1) facts.push(["Objects", `${details.placements} show it`]);
  if (match) facts.unshift(["Match", [kindText(match.evidence), figures(match)].filter(Boolean).join("; ")]);
  const rows = facts.flatMap(([name, value]) => [make("dt", {}, name), make("dd", {}, value)]);
  const tags = make("dd", { class: "tags" }, ...(details.tags.length ? details.tags.flatMap((tag) => [tag, untag(shape, tag), " "]) : ["none"]));
  byId("facts").replaceChildren(...rows, make("dt", {}, "Tags"), tags);
  const buttons = actions.map(({ label, run }) => make("button", { type: "button", onclick: () => act(run) }, label));
  if (state.info?.allow_download && details.source.root) {
    buttons.push(make("a", { class: "button", href: `/api/shapes/${shape.shape_id}/file`, download: "" }, "Download the file"));
  }
  byId("actions").replaceChildren(...buttons);
  byId("tagging").hidden = state.scope !== "write";
  byId("tagging").onsubmit = (event) => {
    event.preventDefault();
    const input = event.target.elements.tag;
    const tag = input.value.trim();
    if (!tag) return;
    act(async () => {
      await post("decisions", { kind: "tag", shape: { shape_id: shape.shape_id }, tag, author: author() });
      input.value = "";
      if (shown === session) await describe(shape, match, actions);
    });
  };

  function untag(of, tag) {
    if (state.scope !== "write") return null;
    const run = async () => {
      await post("decisions", { kind: "no tag", shape: { shape_id: of.shape_id }, tag, author: author() });
      if (shown === session) await describe(shape, match, actions);
    };
    return make("button", { type: "button", "aria-label": `Remove the tag ${tag}`, onclick: () => act(run) }, "✕");
  }
}

async function act(run) {
  try {
    say(byId("compare-state"), (await run()) ?? "");
  } catch (error) {
    say(byId("compare-state"), error.message, true);
  }
}

function close() {
  shown = null;
  end?.();
  end = null;
}

export function closeDialog() {
  byId("compare").close();
}

export function prepareCompare() {
  byId("compare").addEventListener("close", close);
}
