// SPDX-License-Identifier: MIT
// Figures as people read them.

export const KINDS = [
  "identical", "moved", "scaled", "mirrored", "re-meshed", "version", "re-posed", "part of", "contains", "similar",
  "same kind", "nothing in common",
];
export const TYPES = [
  "file", "object", "point cloud", "curve", "text", "surface", "metaball", "collection", "instance", "scatter",
];
const WEAK = new Set(["similar", "same kind", "nothing in common"]);

export const percent = (share) => `${Math.round(100 * share)} %`;

export function kindText(evidence) {
  if (!evidence) return "";
  const parts = [evidence.kind];
  if (evidence.factor && Math.abs(evidence.factor - 1) > 0.001) parts.push(`×${Number(evidence.factor.toPrecision(3))}`);
  if (evidence.share) parts.push(percent(evidence.share));
  return parts.join(" ");
}

export const isWeak = (evidence) => !evidence || WEAK.has(evidence.kind);

export function figures(match) {
  const parts = [`same shape ${percent(match.similarity)}`];
  if (match.likeness !== null) parts.push(`same kind ${percent(match.likeness)}`);
  return parts.join(", ");
}
