'use strict';
// Messages between a page and its windows, by a channel that has nothing to do with who opened whom; and screens that stay on.

// WebKit hands on no channel between files from disk: there a window talks with its opener, and shares its process.
const APART = typeof BroadcastChannel !== 'undefined' && (location.protocol.startsWith('http') || !navigator.vendor.startsWith('Apple'));

class Wire {
  constructor(name, hear) {
    this.name = name;
    this.peers = new Set(); // without a channel
    if (APART) {
      this.channel = new BroadcastChannel(name);
      this.channel.onmessage = ({data}) => hear(data);
      return;
    }
    if (opener) this.peers.add(opener);
    addEventListener('message', ({data, source, origin}) => {
      if (origin !== self.origin || !source || !data || data.wire !== name) return;
      this.peers.add(source);
      hear(data.message);
    });
  }

  post(message) {
    if (APART) return this.channel.postMessage(message);
    for (const peer of this.peers)
      if (peer.closed) this.peers.delete(peer);
      else peer.postMessage({wire: this.name, message}, '*');
  }
}

// While this page is seen, no screen goes dark: a projector is one of them. A browser ends it with every hiding of the page.
function stayAwake() {
  const ask = () => document.hidden || !navigator.wakeLock || navigator.wakeLock.request('screen').catch(() => {});
  document.addEventListener('visibilitychange', ask);
  ask();
}
