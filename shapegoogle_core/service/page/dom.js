// SPDX-License-Identifier: MIT
// Making and filling elements. Texts of shapes are always set as text, never as HTML.

export const byId = (id) => document.getElementById(id);

export function make(tag, properties = {}, ...children) {
  const element = document.createElement(tag);
  for (const [name, value] of Object.entries(properties)) {
    if (name === "class") element.className = value;
    else if (name.startsWith("on")) element.addEventListener(name.slice(2), value);
    else if (name in element) element[name] = value;
    else element.setAttribute(name, value);
  }
  element.append(...children.filter((child) => child !== null && child !== undefined));
  return element;
}

// A picture, or a word in its place.
export function picture(address, label) {
  const image = make("img", { src: address, alt: label, loading: "lazy", decoding: "async", draggable: false });
  image.addEventListener("error", () => image.replaceWith(make("div", { class: "none", role: "img", "aria-label": label }, "no picture")));
  return image;
}

export function say(element, text, bad = false) {
  element.textContent = text;
  element.classList.toggle("bad", bad);
}

export const counted = (count, noun) => `${count.toLocaleString("en")} ${noun}${count === 1 ? "" : "s"}`;
export const title = (shape) => shape.object_name || shape.name;
export const place = (source) => (source.root ? `${source.root}/${source.path}` : source.path);
