// SPDX-License-Identifier: Apache-2.0
// Fetches the newest map: never two at once, and none that is out of date before it arrives.

/** A fetch that does not move must not hold up all later ones. */
const longestFetchMs = 60000;

export class SceneFetcher {
  /** For tests: fetches begun so far. */
  begun = 0;
  private wanted = false;
  private busy = false;

  constructor(private readonly path: string, private readonly take: (bytes: Uint8Array) => void) {}

  /** The map has changed. */
  async request(): Promise<void> {
    this.wanted = true;
    if (this.busy) return;
    this.busy = true;
    while (this.wanted) {
      this.wanted = false;
      const begin = performance.now();
      await this.fetchOnce();
      // At most half of the time is spent on maps, however large they become.
      await new Promise((done) => setTimeout(done, performance.now() - begin));
    }
    this.busy = false;
  }

  private async fetchOnce(): Promise<void> {
    this.begun++;
    try {
      const response = await fetch(this.path, { cache: 'no-store', signal: AbortSignal.timeout(longestFetchMs) });
      // Before the first map the server has none; another message follows when it has.
      if (response.ok) this.take(new Uint8Array(await response.arrayBuffer()));
    } catch {
      // The connection of the run tells the person that the server is gone.
    }
  }
}
