// SPDX-License-Identifier: Apache-2.0
// Saves the 3D view as a PNG file.
import type { App } from '../app';

export function savePicture(app: App): void {
  app.view.drawAll();
  app.view.canvas.toBlob((blob) => {
    if (blob) saveAs(app, blob, 'png');
  });
}

/** As a download, named after the run. */
export function saveAs(app: App, blob: Blob, extension: string): void {
  const link = document.createElement('a');
  link.href = URL.createObjectURL(blob);
  link.download = `${(app.active?.name ?? 'map').replace(/[^\w.-]+/g, '_')}.${extension}`;
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 10000);
}
