// The picture: tissue, fibres, tips, obstacles and tools, by three.js.

import * as THREE from "three";
import { OrbitControls } from "./vendor/OrbitControls.js";
import { colours } from "./colours.js";

const BACKGROUND = 0xeceff2;

export class View {
  constructor(canvas) {
    this.canvas = canvas;
    this.renderer = new THREE.WebGLRenderer({ canvas, antialias: true });
    this.renderer.setPixelRatio(Math.min(window.devicePixelRatio, 2));
    this.scene = new THREE.Scene();
    this.scene.background = new THREE.Color(BACKGROUND);
    this.camera = new THREE.PerspectiveCamera(30, 1, 0.1, 1000);
    this.camera.up.set(0, 0, 1);
    this.controls = new OrbitControls(this.camera, canvas);
    this.controls.addEventListener("change", () => { this.isStale = true; });
    this.raycaster = new THREE.Raycaster();
    this.light = new THREE.DirectionalLight(0xffffff, 1.6);
    this.scene.add(new THREE.HemisphereLight(0xffffff, 0xb8c0c8, 1.9), this.light);
    this.#makeObjects();
    new ResizeObserver(() => this.#resize()).observe(canvas.parentElement);
    this.isStale = true;
  }

  #makeObjects() {
    const behind = { polygonOffset: true, polygonOffsetFactor: 2, polygonOffsetUnits: 2 };
    this.shell = new THREE.MeshLambertMaterial({ vertexColors: true, side: THREE.DoubleSide, flatShading: true, ...behind });
    this.flat = new THREE.MeshBasicMaterial({ vertexColors: true, side: THREE.DoubleSide, ...behind });
    this.geometry = new THREE.BufferGeometry();
    this.tissue = new THREE.Mesh(this.geometry, this.shell);
    this.wires = new THREE.Mesh(this.geometry, new THREE.MeshBasicMaterial({ color: 0x10202e, wireframe: true, transparent: true, opacity: 0.3 }));
    this.wires.visible = false;
    // Tissue that lies on an obstacle is drawn before it.
    const solid = { color: 0xa9b2bb, flatShading: true, polygonOffset: true, polygonOffsetFactor: 4, polygonOffsetUnits: 16 };
    this.obstacles = new THREE.Mesh(new THREE.BufferGeometry(), new THREE.MeshLambertMaterial(solid));
    const lines = (color, opacity = 1) =>
      new THREE.LineSegments(new THREE.BufferGeometry(), new THREE.LineBasicMaterial({ color, transparent: opacity < 1, opacity }));
    this.fibres = lines(0xffffff, 0.55);
    this.directions = lines(0xd1287f);
    this.grips = lines(0x0b5394);
    const points = { color: 0xd1287f, size: 9, sizeAttenuation: false, depthTest: false };
    this.tips = new THREE.Points(new THREE.BufferGeometry(), new THREE.PointsMaterial(points));
    const jaws = new THREE.MeshLambertMaterial({ color: 0x0b5394, transparent: true, opacity: 0.75 });
    this.jaws = new THREE.Mesh(new THREE.SphereGeometry(1, 24, 16), jaws);
    this.jaws.visible = false;
    this.blade = lines(0xa33a00);
    this.blade.material.depthTest = false;
    const all = [this.tissue, this.wires, this.obstacles, this.fibres, this.directions, this.grips, this.tips, this.jaws, this.blade];
    all.forEach((object) => { object.frustumCulled = false; });
    this.scene.add(...all);
  }

  #resize() {
    const { clientWidth, clientHeight } = this.canvas.parentElement;
    if (!clientWidth || !clientHeight) return;
    this.renderer.setSize(clientWidth, clientHeight, false);
    this.camera.aspect = clientWidth / clientHeight;
    this.camera.updateProjectionMatrix();
    this.isStale = true;
  }

  /** Puts the camera where all of it is seen: from above a plane, at a slant before what is none. */
  fit(positions, isPlanar) {
    const box = new THREE.Box3().setFromArray(positions);
    const sphere = box.getBoundingSphere(new THREE.Sphere());
    this.size = Math.max(sphere.radius, 1e-9);
    const size = box.getSize(new THREE.Vector3());
    const half = isPlanar ? Math.max(size.y, size.x / this.camera.aspect) / 2 : this.size / Math.min(1, this.camera.aspect);
    const fov = THREE.MathUtils.degToRad(this.camera.fov / 2);
    const far = (1.12 * Math.max(half, 1e-9)) / Math.tan(fov);
    const way = isPlanar ? new THREE.Vector3(0, -0.0001, 1) : new THREE.Vector3(0, -0.62, 1);
    this.controls.target.copy(sphere.center);
    this.camera.position.copy(sphere.center).addScaledVector(way.normalize(), far);
    this.camera.near = far / 100;
    this.camera.far = far * 20;
    this.camera.updateProjectionMatrix();
    this.controls.update();
    this.tissue.material = isPlanar ? this.flat : this.shell;
    this.isStale = true;
  }

  /** Shows a state. */
  show({ positions, indices, values, fibres, tips, tipDirections, grips, solids, solidIndices, place }, high, jawRadius) {
    setSurface(this.geometry, positions, indices);
    if (this.geometry.getAttribute("color")?.array.length !== positions.length) {
      this.geometry.setAttribute("color", new THREE.BufferAttribute(new Float32Array(positions.length), 3));
    }
    const colour = this.geometry.getAttribute("color");
    colours(values, high, colour.array);
    colour.needsUpdate = true;
    this.geometry.boundingSphere = null;
    setSurface(this.obstacles.geometry, solids, solidIndices);
    setPoints(this.fibres.geometry, fibres);
    setPoints(this.tips.geometry, tips);
    setPoints(this.directions.geometry, tipDirections);
    setPoints(this.grips.geometry, grips);
    this.jaws.visible = Boolean(place);
    if (place) this.jaws.position.fromArray(place);
    this.jaws.scale.setScalar(jawRadius);
    this.isStale = true;
  }

  /** The ray under a place of the picture, from −1 to 1 either way. */
  ray(x, y) {
    this.camera.updateMatrixWorld();
    this.raycaster.setFromCamera(new THREE.Vector2(x, y), this.camera);
    const { origin, direction } = this.raycaster.ray;
    return { origin: origin.toArray(), direction: direction.toArray() };
  }

  /** The first point of the tissue under a place of the picture. */
  pick(x, y) {
    if (!this.geometry.getIndex()) return null;
    this.ray(x, y);
    return this.raycaster.intersectObject(this.tissue)[0]?.point ?? null;
  }

  /** The point under a place of the picture in the plane through `through` that faces the viewer, or lies as a plane body does. */
  onPlane(x, y, through, isPlanar) {
    this.ray(x, y);
    const normal = isPlanar ? new THREE.Vector3(0, 0, 1) : this.camera.getWorldDirection(new THREE.Vector3());
    const plane = new THREE.Plane().setFromNormalAndCoplanarPoint(normal, through);
    return this.raycaster.ray.intersectPlane(plane, new THREE.Vector3());
  }

  /** How large a pixel is at a point. */
  pixel(point) {
    const far = this.camera.position.distanceTo(point);
    return (2 * far * Math.tan(THREE.MathUtils.degToRad(this.camera.fov / 2))) / this.canvas.clientHeight;
  }

  /** Where a point of space is in the picture, from −1 to 1 either way. */
  project(point) {
    return new THREE.Vector3().copy(point).project(this.camera);
  }

  vector(array) {
    return new THREE.Vector3().fromArray(array);
  }

  /** Right and up of the viewer. */
  axes() {
    this.camera.updateMatrixWorld();
    const [right, up] = [new THREE.Vector3(), new THREE.Vector3()];
    this.camera.matrixWorld.extractBasis(right, up, new THREE.Vector3());
    return [right, up];
  }

  turn(angle) {
    const arm = this.camera.position.clone().sub(this.controls.target).applyAxisAngle(this.camera.up, angle);
    this.camera.position.copy(this.controls.target).add(arm);
    this.controls.update();
    this.isStale = true;
  }

  zoom(factor) {
    const arm = this.camera.position.clone().sub(this.controls.target).multiplyScalar(factor);
    this.camera.position.copy(this.controls.target).add(arm);
    this.controls.update();
    this.isStale = true;
  }

  showBlade(from, to) {
    setPoints(this.blade.geometry, from ? new Float32Array([...from.toArray(), ...to.toArray()]) : new Float32Array());
    this.isStale = true;
  }

  render() {
    if (!this.isStale) return;
    this.isStale = false;
    this.light.position.copy(this.camera.position).add(new THREE.Vector3(-this.size, this.size, this.size));
    this.renderer.render(this.scene, this.camera);
  }
}

/** Places the vertices of triangles, and takes their rows over where they are others. */
function setSurface(geometry, positions, indices) {
  const held = geometry.getAttribute("position");
  if (held?.array.length === positions.length) {
    held.array.set(positions);
    held.needsUpdate = true;
  } else {
    geometry.setAttribute("position", new THREE.BufferAttribute(positions, 3));
  }
  const rows = geometry.getIndex()?.array;
  const isSame = rows?.length === indices.length && rows.every((row, i) => row === indices[i]);
  if (!isSame) geometry.setIndex(new THREE.BufferAttribute(indices, 1));
}

/** Refills a buffer, and makes a longer one where it does not suffice. */
function setPoints(geometry, numbers) {
  const held = geometry.getAttribute("position");
  if (held && held.array.length >= numbers.length) {
    held.array.set(numbers);
    held.needsUpdate = true;
  } else {
    geometry.dispose();
    const room = new Float32Array(Math.ceil(numbers.length * 1.25 / 6) * 6);
    room.set(numbers);
    geometry.setAttribute("position", new THREE.BufferAttribute(room, 3));
  }
  geometry.setDrawRange(0, numbers.length / 3);
}
