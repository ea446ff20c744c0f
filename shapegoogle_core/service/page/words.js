// SPDX-License-Identifier: MIT
// Figures as people read them.

export const KINDS = [
  "identical", "moved", "scaled", "mirrored", "re-meshed", "version", "re-posed", "part of", "contains", "similar",
  "same kind", "nothing in common",
];
export const TYPES = [
  "file", "object", "point cloud", "curve", "text", "surface", "metaball", "collection", "instance", "scatter",
];
// Kinds of two different surfaces, whose sizes say nothing.
const WEAK = new Set(["similar", "same kind", "nothing in common"]);
const SHOWN_FACTOR = 0.02;

export const percent = (share) => `${Math.round(100 * share)} %`;

// As `evidence_text` of shapegoogle_core/rendering/text.py.
export function kindText(evidence) {
  if (!evidence) return "";
  const { kind, share = null, factor = 1 } = evidence;
  let text = kind;
  if (share !== null) text = kind === "part of" ? `the query is ${percent(share)} of it` : `${percent(share)} of the query`;
  const hasSize = !WEAK.has(kind) && Math.abs(factor - 1) > SHOWN_FACTOR;
  return hasSize ? `${text} ×${Number(factor.toPrecision(3))}` : text;
}

export const isWeak = (evidence) => !evidence || WEAK.has(evidence.kind);

export function figures(match) {
  const parts = [`same shape ${percent(match.similarity)}`];
  if (match.likeness !== null) parts.push(`same kind ${percent(match.likeness)}`);
  return parts.join(", ");
}
