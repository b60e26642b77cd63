'use strict';
// Photographs with a calibration, as docs/guide/own-rig.md lays them out: what of the dropped files is what, asked of the user with the
// likely answers filled in.

const PHOTOGRAPH = /\.(png|jpe?g)$/i;

function folderOf(path) {
  return path.replace(/\/?[^/]*$/, '');
}

function fillSelect(select, paths, likely, none) {
  const choices = [...none ? [['', none]] : [], ...paths.map((path) => [path, path])];
  select.replaceChildren(...choices.map(([value, text]) => new Option(text, value)));
  const found = paths.find((path) => likely.test(path));
  if (found) select.value = found;
}

// Folders view-000, view-045, .., or 000, 045, ..: where they lie, as FILES of `ffprocams import -i`, and the angles that they are named by.
function viewFolders(paths) {
  const views = new Map();
  let files = '';
  for (const path of paths.filter((one) => PHOTOGRAPH.test(one)).sort()) {
    const [, before, view, name] = path.match(/^(.*\/(?:view-)?)(-?[\d.]+)\/([^/]+)$/) ?? [];
    if (!view) continue;
    files ||= `${before}{view}/*.${name.split('.').pop()}`;
    views.set(view, Number(view));
  }
  const angles = [...views.values()];
  return { files, angles };
}

// Of files that are neither a capture nor photographs from which one is made.
function whyNothing(paths, calibrations) {
  if (!paths.length) return 'There are no files in it.';
  if (paths.length === 1 && !paths[0].includes('/')) return `"${paths[0]}" is one file: drop the folder of a capture, or a ZIP file of it.`;
  const what = paths[0].includes('/') ? `"${paths[0].split('/')[0]}"` : 'This';
  const photographs = paths.filter((path) => PHOTOGRAPH.test(path)).length;
  return `${what} is not a capture: there is no scene.json (or render_poses.json) in it. To make one, the page needs photographs as PNG or JPEG files (found: ${photographs}) and a calibration as an .xml, .yml or .json file (found: ${calibrations}).`;
}

function askAboutPhotographs(files) {
  const paths = files.map(({ path }) => path);
  const texts = paths.filter((path) => /\.(xml|ya?ml|json)$/i.test(path) && !/\/patterns\//.test(path));
  if (!texts.length || !paths.some((path) => PHOTOGRAPH.test(path))) throw new Message(whyNothing(paths, texts.length));
  const { files: images, angles } = viewFolders(paths);
  fillSelect($('calibration'), texts, /calib|param|transforms|cameras/i);
  fillSelect($('turntable'), texts, /axis|turntable/i, 'none: the object did not turn');
  fillSelect($('shown'), [...new Set(paths.filter((path) => PHOTOGRAPH.test(path)).map(folderOf))], /patterns$/, 'as the calibration names them');
  $('images').value = images;
  $('angles').value = angles.join(',');
  $('photographs').hidden = false;
  $('photographs').scrollIntoView({ block: 'nearest' });
}

// "0,45,90" or "8x45" as numbers.
function readAngles(text) {
  const [, count, step] = text.match(/^\s*(\d+)\s*x\s*(-?[\d.]+)\s*$/) ?? [];
  const angles = count ? Array.from({ length: Math.min(Number(count), 512) }, (_, i) => i * Number(step)) : text.split(',').filter((part) => part.trim()).map(Number);
  if (angles.some(Number.isNaN)) throw new Message(`angles: "${text}" is neither 0,45,90 nor 8x45`);
  return angles;
}

function photographChoices() {
  return {
    calibration: $('calibration').value, turntable: $('turntable').value, angles: readAngles($('angles').value), shown: $('shown').value,
    images: $('images').value.trim(), width: Number($('width').value) || 0, response: $('response').checked,
  };
}
