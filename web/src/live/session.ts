// SPDX-License-Identifier: Apache-2.0
// A run that goes on: takes its messages, keeps what they say, and tells the page about once a picture.
import type { App } from '../app';
import { SceneError } from '../scene/scene';
import { Connection, type Link } from './connection';
import { ImageStore } from './image_store';
import { LiveMap } from './live_map';
import { readBinary, readText, type Calibration, type Command, type Hello, type LiveFrame, type LiveImage, type LivePlace, type Message, type Status } from './messages';
import { LiveRecord } from './record';
import { SceneFetcher } from './scene_fetcher';

export type News = 'link' | 'hello' | 'status' | 'calibration' | 'frames' | 'image' | 'place' | 'following' | 'unreadable';

const shortestPauseMs = 12;
const mostPlaces = 50;

export class LiveSession {
  readonly record = new LiveRecord();
  readonly images = new ImageStore();
  /** The last ones, the oldest first. */
  places: LivePlace[] = [];
  readonly connection: Connection;
  readonly fetcher: SceneFetcher;
  hello: Hello | null = null;
  /** What the run says of itself; null until it does. */
  status: Status | null = null;
  newest: LiveFrame | null = null;
  /** Of a calibration: what was shown so far. */
  calibration: Calibration | null = null;
  following = true;
  /** Messages that could not be read, and what was wrong with the last of them. */
  unreadable = { count: 0, line: '' };
  private readonly map: LiveMap;
  private readonly listeners: ((news: Set<News>) => void)[] = [];
  private readonly news = new Set<News>();
  private readonly sceneIndex: number;
  private scheduled = false;
  private nextFlush = 0;
  private growing = false;
  private fresh = false;

  constructor(app: App, { run, scene }: { run: number; scene: number }, query: string) {
    this.sceneIndex = scene;
    this.map = new LiveMap(app, run, this.record);
    this.fetcher = new SceneFetcher(`/api/scene/${scene}${query}`, (bytes) => this.takeScene(bytes));
    const url = `${location.protocol === 'https:' ? 'wss' : 'ws'}://${location.host}/live${query}`;
    this.connection = new Connection(url, {
      linked: () => this.tell('link'),
      opened: (again) => this.opened(again),
      received: (data) => this.received(data),
    });
    app.onChange((changed) => {
      if (changed.has('frame') && !this.growing) this.setFollowing(app.state.frame >= this.record.count - 1);
    });
  }

  start(): void {
    this.connection.connect();
  }

  get link(): Link {
    return this.connection.link;
  }

  onNews(listener: (news: Set<News>) => void): void {
    this.listeners.push(listener);
  }

  send(command: Command): boolean {
    return this.connection.send(JSON.stringify({ command }));
  }

  /** Back to the newest frame, and along with it from now on. */
  follow(): void {
    this.setFollowing(true);
    this.tell('frames');
  }

  private setFollowing(on: boolean): void {
    if (on === this.following) return;
    this.following = on;
    this.tell('following');
  }

  private opened(again: boolean): void {
    this.fresh = true;
    // What changed in the meantime was told to nobody; a map that was there already is not fetched twice.
    if (again || !this.map.hasMap) void this.fetcher.request();
  }

  private received(data: string | ArrayBuffer): void {
    try {
      if (typeof data !== 'string') return this.takeBlock(readBinary(new Uint8Array(data)));
      const message = readText(data, this.record.stateNames.length);
      if (message) this.take(message);
    } catch (error) {
      if (!(error instanceof SceneError)) throw error;
      this.complain(error.message);
    }
  }

  private take(message: Message): void {
    switch (message.type) {
      case 'hello':
        return this.takeHello(message);
      case 'frame':
        return this.takeFrame(message);
      case 'scene':
        if (message.index === this.sceneIndex) void this.fetcher.request();
        return;
      case 'calibration':
        this.calibration = message;
        return this.tell('calibration');
      case 'status':
        // The frames so far are of a map that is no longer this one.
        if (this.status && message.resets > this.status.resets) this.forgetMap();
        this.status = message;
        this.connection.runEnded = message.ended;
        return this.tell('status');
    }
  }

  private takeHello(hello: Hello): void {
    this.hello = hello;
    // States that only a scene named stay behind those of the run.
    this.record.stateNames = [...hello.stateNames, ...this.record.stateNames.slice(hello.stateNames.length)];
    this.map.name(hello.title, hello.method);
    this.tell('hello');
  }

  private takeFrame(frame: LiveFrame): void {
    // After a new connection, an earlier frame is the first one of another run.
    if (this.fresh && frame.index < this.record.lastIndex && frame.stamp < this.record.lastStamp) this.forget();
    this.fresh = false;
    if (!this.record.append(frame)) return;
    this.newest = frame;
    this.tell('frames');
  }

  private forgetMap(): void {
    this.fetcher.drop();
    this.growing = true;
    this.map.remove();
    this.growing = false;
    this.forget();
  }

  private forget(): void {
    this.newest = null;
    this.record.clear();
    this.images.clear();
    this.places = [];
    this.map.clear();
  }

  private takeBlock(block: LiveImage | LivePlace | null): void {
    if (block?.type === 'image' && this.images.add(block)) this.tell('image');
    if (block?.type !== 'place') return;
    this.places = [...this.places, block].slice(-mostPlaces);
    this.tell('place');
  }

  private takeScene(bytes: Uint8Array): void {
    this.growing = true;
    try {
      this.map.replace(bytes);
    } catch (error) {
      if (!(error instanceof SceneError)) throw error;
      this.complain(`the map: ${error.message}`);
    } finally {
      this.growing = false;
    }
    this.tell('frames');
  }

  private complain(line: string): void {
    this.unreadable = { count: this.unreadable.count + 1, line };
    this.tell('unreadable');
  }

  /** About once a picture, so that a burst of messages costs few passes over the page. Not in a picture's own callback:
   * what is asked for there is drawn one picture later. */
  private tell(news: News): void {
    this.news.add(news);
    if (this.scheduled) return;
    this.scheduled = true;
    setTimeout(() => this.flush(), Math.max(0, this.nextFlush - performance.now()));
  }

  private flush(): void {
    this.scheduled = false;
    const begin = performance.now();
    const news = new Set(this.news);
    this.news.clear();
    this.growing = true;
    if (news.has('frames')) this.map.grow(this.following);
    this.growing = false;
    for (const listener of this.listeners) listener(news);
    const end = performance.now();
    this.nextFlush = end + Math.max(shortestPauseMs, 2 * (end - begin));
  }
}
