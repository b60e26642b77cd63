'use strict';
// The studio's page on its server: files of the folder and windows have addresses.

const platform = {
  served: true,

  // Every request that changes something; the state that comes back.
  async post(path, body) {
    let answer;
    try {
      answer = await fetch(path, {method: 'POST', body});
    } catch {
      throw new Error('The studio does not answer: it has ended. Start it again with the same folder; nothing is lost.');
    }
    if (!answer.headers.get('Content-Type').startsWith('application/json')) throw new Error(await answer.text());
    return answer.json();
  },

  // Empty if the one that is known is the last.
  async state(known) {
    const answer = await fetch('state?known=' + known);
    if (!answer.ok) throw new Error(await answer.text());
    return answer.json();
  },

  async blob(path) {
    const answer = await fetch('file/' + path);
    if (!answer.ok) throw new Error(`${path} cannot be read (${answer.status}).`);
    return answer.blob();
  },

  // Puts a file into an image or a frame, or behind a link.
  put(node, path) { node[node.tagName === 'A' ? 'href' : 'src'] = 'file/' + path; },

  projector(number, place) { return window.open('projector', `ffp-projector-${number}`, place); },
};
