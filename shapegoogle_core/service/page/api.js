// SPDX-License-Identifier: MIT
// Requests to the service. An answer with an error becomes an Error with its sentence.

import { byId, say } from "./dom.js";

export class Failed extends Error {
  constructor(status, sentence) {
    super(sentence);
    this.status = status;
  }
}

async function request(path, options) {
  let answer;
  try {
    answer = await fetch(`/api/${path}`, { credentials: "same-origin", ...options });
  } catch {
    throw new Failed(0, "The service does not answer; check the connection and try again.");
  }
  if (answer.ok) return answer;
  let sentence = `The service answered with code ${answer.status}.`;
  try {
    sentence = (await answer.json()).error;
  } catch {
    // Not from the service itself: a proxy's own page.
  }
  if (answer.status === 401) signIn();
  throw new Failed(answer.status, sentence.charAt(0).toUpperCase() + sentence.slice(1) + ".");
}

const json = (method, body) => ({ method, headers: { "Content-Type": "application/json" }, body: JSON.stringify(body) });

export const get = async (path) => (await request(path)).json();
export const post = async (path, body) => (await request(path, json("POST", body))).json();
export const remove = async (path) => (await request(path, { method: "DELETE" })).json();
export const bytes = async (path) => (await request(path)).arrayBuffer();

export async function upload(file) {
  const form = new FormData();
  form.append("file", file);
  return (await request("uploads", { method: "POST", body: form })).json();
}

// Ask again until an answer that takes long is there.
export async function patiently(path, waiting) {
  for (;;) {
    const answer = await get(path);
    if (answer.ready) return answer;
    waiting();
    await new Promise((resolve) => setTimeout(resolve, 2000));
  }
}

function signIn() {
  const dialog = byId("sign-in");
  if (!dialog.open) dialog.showModal();
}

export function prepareSignIn() {
  byId("sign-in-form").addEventListener("submit", async (event) => {
    event.preventDefault();
    try {
      await post("session", { token: event.target.elements.token.value.trim() });
      location.reload();
    } catch (error) {
      say(byId("sign-in-state"), error.message, true);
    }
  });
}

export const thumbnail = (example) =>
  example.upload ? `/api/uploads/${example.upload}/${example.index}/thumbnail` : `/api/shapes/${example.shape_id}/thumbnail`;
export const preview = (example) =>
  example.upload ? `uploads/${example.upload}/${example.index}/preview` : `shapes/${example.shape_id}/preview`;
