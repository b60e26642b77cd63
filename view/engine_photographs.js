'use strict';
// Photographs with a calibration, as docs/guide/own-rig.md lays them out: what of the dropped files is what, asked of the user with the
// likely answers filled in.

const PHOTOGRAPH = /\.(png|jpe?g)$/i;

const naturally = new Intl.Collator('en', { numeric: true }).compare; // as `import` orders views

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
  for (const path of paths.filter((one) => PHOTOGRAPH.test(one)).sort(naturally)) {
    const [, before, view, name] = path.match(/^(.*\/(?:view-)?)(-?[\d.]+)\/([^/]+)$/) ?? [];
    if (!view) continue;
    files ||= `${before}{view}/*.${name.split('.').pop()}`;
    views.set(view, Number(view));
  }
  const angles = [...views.values()];
  return { files, angles };
}

// Of files that are neither a capture nor photographs from which one is made.
function whyNothing(paths) {
  if (!paths.length) return 'There are no files in it.';
  if (paths.length === 1 && !paths[0].includes('/')) return `"${paths[0]}" is one file: drop the folder of a capture, or a ZIP file of it.`;
  const what = paths[0].includes('/') ? `"${paths[0].split('/')[0]}"` : 'This';
  return `${what} is not a capture: there is no scene.json (or render_poses.json) in it. To make one, the page needs photographs as PNG or JPEG files: there are none.`;
}

// Angles that folders seem to be named by: 0, 45, .. rather than 1, 2, ..
const likelyAngles = (angles) => (angles.length > 1 && angles.every((angle, i) => i === 0 || angle - angles[i - 1] > 1) ? angles.join(',') : '');

function askAboutPhotographs(files) {
  const paths = files.map(({ path }) => path);
  const texts = paths.filter((path) => /\.(xml|ya?ml|json)$/i.test(path) && !/\/patterns\//.test(path));
  if (!paths.some((path) => PHOTOGRAPH.test(path))) throw new Message(whyNothing(paths));
  const { files: images, angles } = viewFolders(paths);
  fillSelect($('calibration'), texts, /calib|param|transforms|cameras/i, 'none: the Gray codes in the photographs tell it');
  fillSelect($('turntable'), texts, /axis|turntable/i, 'none');
  fillSelect($('shown'), [...new Set(paths.filter((path) => PHOTOGRAPH.test(path)).map(folderOf))], /patterns$/, 'those that the program draws');
  $('images').value = images;
  $('angles').value = likelyAngles(angles);
  showFields();
  $('photographs').hidden = false;
  $('photographs').scrollIntoView({ block: 'nearest' });
}

// Shows the fields that are needed with a calibration, or without.
function showFields() {
  const known = $('calibration').value !== '';
  for (const id of ['turntable', 'images', 'response']) $(id).parentElement.hidden = !known;
  $('panel').parentElement.hidden = $('panel').disabled = known || $('shown').value !== ''; // what is disabled is not checked
}

// "0,45,90" or "8x45" as numbers.
function readAngles(text) {
  const [, count, step] = text.match(/^\s*(\d+)\s*x\s*(-?[\d.]+)\s*$/) ?? [];
  const angles = count ? Array.from({ length: Math.min(Number(count), 512) }, (_, i) => i * Number(step)) : text.split(',').filter((part) => part.trim()).map(Number);
  if (angles.some(Number.isNaN)) throw new Message(`angles: "${text}" is neither 0,45,90 nor 8x45`);
  return angles;
}

function photographChoices(files) {
  const shown = $('shown').value, pictures = files.map(({ path }) => path).filter((path) => PHOTOGRAPH.test(path));
  const folders = [...new Set(pictures.map(folderOf))].filter((folder) => folder !== shown);
  return {
    calibration: $('calibration').value, turntable: $('turntable').value, angles: readAngles($('angles').value), shown,
    panel: $('panel').value.trim(), images: $('images').value.trim(), width: Number($('width').value) || 0, response: $('response').checked,
    folders: folders.sort(naturally),
  };
}

const CAPTURE = '/made/capture';

// The command that makes a capture of what was dropped: `import` where there is a calibration, otherwise `scan`, as far as that.
function captureWords({ calibration, turntable, angles, shown, panel, images, width, response, folders }) {
  const at = (path) => `/dropped/${path}`, option = (name, value) => (value ? [name, value] : []);
  const common = [...angles.length ? [`--angles=${angles.join(',')}`] : [], ...option('--shown', shown && at(shown)), ...option('-w', width && String(width))];
  if (!calibration) return ['scan', ...folders.map(at), ...common, ...shown ? [] : option('--projector', panel), '--to', 'import', '-o', '/made'];
  return ['import', '-c', at(calibration), ...option('-t', turntable && at(turntable)), ...common, '-i', at(images), ...response ? ['--fit-response'] : [], '-o', CAPTURE];
}
