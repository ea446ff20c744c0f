// SPDX-License-Identifier: MIT
// The list of decisions, each of which can be undone.

import { get, remove } from "./api.js";
import { byId, make, say } from "./dom.js";
import { author, setAuthor, state } from "./state.js";

export function prepareDecisions() {
  byId("author").value = author();
  byId("author").addEventListener("change", (event) => setAuthor(event.target.value));
}

export async function showDecisions() {
  // With tokens, decisions have the name of the token.
  byId("author-label").hidden = state.needsToken || state.scope !== "write";
  const status = byId("decisions-state");
  try {
    const { decisions } = await get("decisions");
    byId("made").replaceChildren(...decisions.reverse().map(row));
    say(status, decisions.length ? "" : "Nothing was decided yet.");
  } catch (error) {
    say(status, error.message, true);
  }
}

function row(decision) {
  const when = new Date(decision.time).toLocaleString("en-GB", { dateStyle: "medium", timeStyle: "short" });
  const sentence = decision.sentence.charAt(0).toUpperCase() + decision.sentence.slice(1);
  const undo = async () => {
    try {
      await remove(`decisions/${decision.number}`);
      await showDecisions();
    } catch (error) {
      say(byId("decisions-state"), error.message, true);
    }
  };
  const button = state.scope === "write" ? make("button", { type: "button", onclick: undo }, "Undo") : null;
  return make("li", {}, make("span", {}, sentence), make("small", {}, [decision.author, when].filter(Boolean).join(", ")), button);
}
