// SPDX-License-Identifier: Apache-2.0
// Fetches the newest map: never two at once, and none that is out of date before it arrives.

/** A fetch that does not move must not hold up all later ones. */
const longestFetchMs = 60000;

export class SceneFetcher {
  private wanted = false;
  private busy = false;
  private dropped = 0;

  constructor(private readonly path: string, private readonly take: (bytes: Uint8Array) => void) {}

  /** The map has changed. */
  async request(): Promise<void> {
    this.wanted = true;
    if (this.busy) return;
    this.busy = true;
    try {
      while (this.wanted) await this.update();
    } finally {
      this.busy = false;
    }
  }

  /** What is on its way is of a map that is no more. */
  drop(): void {
    this.dropped++;
    this.wanted = false;
  }

  private async update(): Promise<void> {
    this.wanted = false;
    const [begin, dropped] = [performance.now(), this.dropped];
    const bytes = await this.fetched();
    if (bytes && dropped === this.dropped) this.take(bytes);
    // At most half of the time is spent on maps, however large they become.
    await new Promise((done) => setTimeout(done, performance.now() - begin));
  }

  /** Null where there is none. */
  private async fetched(): Promise<Uint8Array | null> {
    try {
      const response = await fetch(this.path, { cache: 'no-store', signal: AbortSignal.timeout(longestFetchMs) });
      // Before the first map the server has none; another message follows when it has.
      return response.ok ? new Uint8Array(await response.arrayBuffer()) : null;
    } catch {
      // The connection of the run tells the person that the server is gone.
      return null;
    }
  }
}
