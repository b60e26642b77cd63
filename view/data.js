'use strict';
// The data in the file: the scene as JSON, and bytes as base64 (src/product/view/view.h describes their layout).

function readBytes(text) {
  const clean = text.trim();
  if (Uint8Array.fromBase64) return Uint8Array.fromBase64(clean);
  const binary = atob(clean), bytes = new Uint8Array(binary.length);
  for (let i = 0; i < binary.length; i++) bytes[i] = binary.charCodeAt(i);
  return bytes;
}

// As ffp_pack_splats wrote them.
function readSplats(scene, bytes) {
  const n = scene.count, view = new DataView(bytes.buffer, bytes.byteOffset, bytes.byteLength);
  const centre = new Float32Array(3 * n), columns = [];
  for (let i = 0; i < 3 * n; i++) centre[i] = view.getFloat32(4 * i, true);
  for (let k = 0; k < scene.low.length; k++) {
    const column = new Float32Array(n), at = 12 * n + 2 * n * k, step = (scene.high[k] - scene.low[k]) / 65535;
    for (let i = 0; i < n; i++) column[i] = scene.low[k] + step * view.getUint16(at + 2 * i, true);
    columns.push(column);
  }
  for (let k = 0; k < 3; k++) columns[k] = columns[k].map(Math.exp);
  return {
    count: n, centre, scale: columns.slice(0, 3), rotation: columns.slice(3, 7), opacity: columns[7],
    albedo: columns.slice(8, 11), roughness: columns[11], ambient: columns.slice(12, 15),
    scattered: columns.length > 15 ? columns.slice(15, 18) : null, // only where any light is
  };
}

function readScene() {
  const scene = JSON.parse(document.getElementById('scene').textContent);
  const element = document.getElementById('data');
  scene.bytes = readBytes(element.textContent);
  element.remove(); // its text is as large again
  scene.splats = readSplats(scene, scene.bytes);
  return scene;
}

// A picture of the file, decoded; null if the page has none.
async function readPicture(scene, entry) {
  if (!entry || !entry.size) return null;
  const bytes = scene.bytes.subarray(entry.at, entry.at + entry.size);
  return createImageBitmap(new Blob([bytes], {type: 'image/png'}), {colorSpaceConversion: 'none'});
}
