// SPDX-License-Identifier: Apache-2.0
// Lengths in the view: lines with dots at their ends, and labels laid over the picture.
import * as THREE from 'three';
import { LineMaterial } from 'three/examples/jsm/lines/LineMaterial.js';
import { LineSegments2 } from 'three/examples/jsm/lines/LineSegments2.js';
import { LineSegmentsGeometry } from 'three/examples/jsm/lines/LineSegmentsGeometry.js';
import type { App } from '../app';
import type { Vec3 } from '../scene/scene';
import { okabeIto } from '../view3d/colors';
import { dots } from '../view3d/materials';
import { el } from '../ui/dom';
import type { Measure } from './measure';
import { lengthOf, measuredOf } from './texts';

interface Mark {
  a: Vec3;
  b: Vec3;
  text: string;
}

export class LengthMarks {
  readonly labels = el('div', { className: 'labels', aria: { hidden: 'true' } });
  private readonly group = new THREE.Group();
  private marks: Mark[] = [];

  constructor(private readonly app: App, private readonly measure: Measure) {
    app.view.marks.add(this.group);
    measure.onChange(() => this.rebuild());
    app.onChange((changed) => {
      if (changed.has('layers') || changed.has('hiddenRuns') || changed.has('theme')) this.rebuild();
    });
    this.rebuild();
  }

  /** After each picture: labels follow the view. */
  update(): void {
    const box = this.app.view.canvas.getBoundingClientRect();
    this.marks.forEach((mark, i) => {
      const middle = mark.a.map((v, axis) => (v + mark.b[axis]) / 2) as Vec3;
      const pixel = this.app.view.project(middle);
      const label = this.labels.children[i] as HTMLElement;
      label.hidden = pixel === null;
      if (pixel) label.style.transform = `translate(${Math.round(pixel[0] - box.left)}px, ${Math.round(pixel[1] - box.top)}px) translate(-50%, -140%)`;
    });
  }

  private rebuild(): void {
    for (const child of [...this.group.children] as (LineSegments2 | THREE.Points)[]) {
      child.geometry.dispose();
      (child.material as THREE.Material).dispose();
      this.group.remove(child);
    }
    this.marks = this.current();
    if (this.marks.length) this.group.add(thickLines(this.marks, this.app.dark));
    const ends = [...this.marks.flatMap((m) => [m.a, m.b]), ...(this.measure.pending ? [this.measure.pending.point] : [])];
    if (ends.length) this.group.add(dots(ends, okabeIto.orange, 10));
    this.labels.replaceChildren(...this.marks.map((m) => el('span', {}, m.text)));
    this.app.view.requestDraw();
  }

  private current(): Mark[] {
    const { app } = this;
    const shown = (run: number) => app.runs[run].group.visible;
    const named = (app.state.layers.lengths ?? true)
      ? app.runs.filter((r) => shown(r.index)).flatMap((r) => r.scene.lengths.map((l) => ({ a: l.a, b: l.b, text: `${l.name} ${lengthOf(app, l, r.index)}` })))
      : [];
    const measured = this.measure.list.filter((m) => shown(m.run)).map((m) => ({ a: m.ends.a, b: m.ends.b, text: `${m.name} ${measuredOf(app, m)}` }));
    return [...named, ...measured];
  }
}

function thickLines(marks: Mark[], dark: boolean): LineSegments2 {
  const geometry = new LineSegmentsGeometry();
  geometry.setPositions(marks.flatMap((m) => [...m.a, ...m.b]));
  const material = new LineMaterial({ linewidth: 2.5, color: dark ? '#ffffff' : '#000000', depthTest: false });
  const lines = new LineSegments2(geometry, material);
  lines.frustumCulled = false;
  lines.renderOrder = 10;
  return lines;
}
