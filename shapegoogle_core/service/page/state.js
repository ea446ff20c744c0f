// SPDX-License-Identifier: MIT
// What all parts of the page know: the library, and what this client may do.

export const state = { info: null, scope: "none", needsToken: false };

const AUTHOR = "shapegoogle.author";

export const author = () => localStorage.getItem(AUTHOR) ?? "";
export const setAuthor = (name) => localStorage.setItem(AUTHOR, name.trim().slice(0, 100));
