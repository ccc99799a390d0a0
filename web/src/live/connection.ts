// SPDX-License-Identifier: Apache-2.0
// The connection to the run. A lost one is tried again, each time after a longer wait, until the run's program is taken
// to have ended.

export type Link = 'connecting' | 'open' | 'lost' | 'gone';

const waitsMs = [200, 400, 800, 1500, 2500, 4000];
/** A program that said its run has ended is not waited for that long. */
const waitsAfterEndMs = [300];
/** A try without an answer (a machine that is switched off sends none) ends after this. */
const longestTryMs = 5000;

export interface Receiver {
  linked(link: Link): void;
  /** The connection stands; the first one, or a later one. */
  opened(again: boolean): void;
  received(data: string | ArrayBuffer): void;
}

export class Connection {
  link: Link = 'connecting';
  /** Set where the end of the connection is expected. */
  runEnded = false;
  private socket: WebSocket | null = null;
  private failures = 0;
  private opened = 0;
  private timer = 0;

  constructor(private readonly url: string, private readonly receiver: Receiver) {}

  connect(): void {
    clearTimeout(this.timer);
    const socket = new WebSocket(this.url);
    socket.binaryType = 'arraybuffer';
    this.socket = socket;
    this.timer = window.setTimeout(() => socket.close(), longestTryMs);
    socket.onopen = () => {
      clearTimeout(this.timer);
      this.change('open');
      this.receiver.opened(this.opened++ > 0);
    };
    socket.onmessage = (event: MessageEvent<string | ArrayBuffer>) => {
      // Only a server that speaks is one: a door that opens and shuts must not be tried for ever at full speed.
      this.failures = 0;
      this.receiver.received(event.data);
    };
    socket.onclose = () => this.closed();
  }

  /** A person asks for another try after the end. */
  retry(): void {
    this.failures = 0;
    this.change('connecting');
    this.connect();
  }

  /** False where there is nobody to send to. */
  send(text: string): boolean {
    if (this.socket?.readyState !== WebSocket.OPEN) return false;
    this.socket.send(text);
    return true;
  }

  private closed(): void {
    clearTimeout(this.timer);
    const waits = this.runEnded ? waitsAfterEndMs : waitsMs;
    if (this.failures >= waits.length) return this.change('gone');
    this.change('lost');
    this.timer = window.setTimeout(() => this.connect(), waits[this.failures++]);
  }

  private change(link: Link): void {
    if (link === this.link) return;
    this.link = link;
    this.receiver.linked(link);
  }
}
