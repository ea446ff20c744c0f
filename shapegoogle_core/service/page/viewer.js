// SPDX-License-Identifier: MIT
// Shows previews in 3-D, upright and turning together; the first is seen as in its thumbnail.

import * as three from "./vendor/three.js";

const STEPS = 65535;
const HEADER = 4 + 3 * 4 + 9 * 4;
// Angle from above, and distance, of the first view; a shape has a bounding sphere of radius 1.
const RAISE = Math.PI / 10;
const DISTANCE = 3.4;

// Reads a preview; its format is described in shapegoogle_core/rendering/preview.py.
export async function readPreview(buffer) {
  const view = new DataView(buffer);
  const [vertexCount, faceCount, upAxis] = [4, 8, 12].map((at) => view.getUint32(at, true));
  const numbers = Array.from({ length: 9 }, (_, index) => view.getFloat32(16 + 4 * index, true));
  const [toward, low, high] = [0, 3, 6].map((at) => numbers.slice(at, at + 3));
  const packed = new Blob([buffer.slice(HEADER)]).stream().pipeThrough(new DecompressionStream("deflate"));
  const data = new DataView(await new Response(packed).arrayBuffer());
  const positions = new Float32Array(3 * vertexCount);
  for (let index = 0; index < positions.length; index += 1) {
    const axis = index % 3;
    positions[index] = low[axis] + (data.getUint16(2 * index, true) / STEPS) * (high[axis] - low[axis]);
  }
  const faces = new Uint16Array(3 * faceCount);
  for (let index = 0; index < faces.length; index += 1) faces[index] = data.getUint16(2 * (positions.length + index), true);
  return { positions, faces, toward, upAxis };
}

function modelOf(preview, color) {
  let geometry = new three.BufferGeometry();
  geometry.setAttribute("position", new three.BufferAttribute(preview.positions, 3));
  let object;
  if (preview.faces.length) {
    geometry.setIndex(new three.BufferAttribute(preview.faces, 1));
    // Flat shading shows the preview as it is: a thousand faces.
    const material = new three.MeshStandardMaterial({ color, roughness: 0.75, flatShading: true, side: three.DoubleSide });
    object = new three.Mesh(geometry, material);
  } else {
    object = new three.Points(geometry, new three.PointsMaterial({ color, size: 0.035 }));
  }
  geometry.computeBoundingSphere();
  const { center, radius } = geometry.boundingSphere;
  geometry.translate(-center.x, -center.y, -center.z);
  const scale = 1 / (radius || 1);
  geometry.scale(scale, scale, scale);
  object.quaternion.copy(upright(preview));
  return object;
}

// Rotation after which y is up. Shapes keep the front that their files give them, so that two that face the same
// way in their files do so here.
function upright(preview) {
  return new three.Quaternion().setFromUnitVectors(new three.Vector3().setComponent(preview.upAxis, 1), new three.Vector3(0, 1, 0));
}

// Angle around the vertical from which the thumbnail looks at a shape.
function azimuth(preview) {
  const toward = new three.Vector3(...preview.toward).applyQuaternion(upright(preview));
  return Math.atan2(toward.x, toward.z);
}

class Viewer {
  constructor({ stage, preview, label }, around, changed) {
    const color = getComputedStyle(document.documentElement).getPropertyValue("--shape").trim();
    this.stage = stage;
    this.renderer = new three.WebGLRenderer({ antialias: true, alpha: true, preserveDrawingBuffer: true });
    this.renderer.setPixelRatio(Math.min(devicePixelRatio, 2));
    const canvas = this.renderer.domElement;
    canvas.tabIndex = 0;
    canvas.setAttribute("role", "img");
    canvas.setAttribute("aria-label", `${label}, to be turned with the arrow keys`);
    stage.replaceChildren(canvas);
    this.scene = new three.Scene();
    this.scene.add(modelOf(preview, color), new three.HemisphereLight(0xffffff, 0x8a8f98, 1.6));
    this.camera = new three.PerspectiveCamera(36, 1, 0.05, 50);
    this.camera.position.setFromSphericalCoords(DISTANCE, Math.PI / 2 - RAISE, around);
    const lamp = new three.DirectionalLight(0xffffff, 2.2);
    lamp.position.set(-1, 1.5, 1);
    this.camera.add(lamp);
    this.scene.add(this.camera);
    this.controls = new three.OrbitControls(this.camera, canvas);
    this.controls.enablePan = false;
    this.controls.minDistance = 1.3;
    this.controls.maxDistance = 12;
    this.controls.addEventListener("change", () => changed(this));
    canvas.addEventListener("keydown", (event) => this.key(event));
    this.observer = new ResizeObserver(() => this.resize());
    this.observer.observe(stage);
    this.resize();
  }

  key(event) {
    const turns = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] }[event.key];
    const zoom = { "+": 0.87, "=": 0.87, "-": 1.15 }[event.key];
    if (!turns && !zoom) return;
    event.preventDefault();
    const position = this.camera.position;
    const radius = position.length();
    const polar = Math.acos(position.y / radius);
    const around = Math.atan2(position.x, position.z);
    const [x, y] = turns ?? [0, 0];
    const lowest = Math.min(Math.max(polar + 0.15 * y, 0.05), Math.PI - 0.05);
    position.setFromSphericalCoords(Math.min(Math.max(radius * (zoom ?? 1), 1.3), 12), lowest, around + 0.15 * x);
    this.controls.update();
  }

  follow(other) {
    this.camera.position.copy(other.camera.position);
    this.camera.quaternion.copy(other.camera.quaternion);
    this.draw();
  }

  resize() {
    const { clientWidth: width, clientHeight: height } = this.stage;
    if (!width || !height) return;
    this.camera.aspect = width / height;
    // A narrow stage must show the whole shape too.
    this.camera.fov = width < height ? 36 * (height / width) ** 0.8 : 36;
    this.camera.updateProjectionMatrix();
    this.renderer.setSize(width, height);
    this.draw();
  }

  draw() {
    this.renderer.render(this.scene, this.camera);
  }

  close() {
    this.observer.disconnect();
    this.controls.dispose();
    this.renderer.dispose();
    this.renderer.forceContextLoss();
  }
}

// Shows previews side by side; returns a function that ends it.
export function show(stages) {
  const viewers = [];
  const changed = (moved) => {
    moved.draw();
    for (const other of viewers) if (other !== moved) other.follow(moved);
  };
  const around = stages.length ? azimuth(stages[0].preview) : 0;
  for (const stage of stages) viewers.push(new Viewer(stage, around, changed));
  return () => viewers.forEach((viewer) => viewer.close());
}
