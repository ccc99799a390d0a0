// SPDX-License-Identifier: Apache-2.0
/** What buttons and keys can do. */
export interface Actions {
  fit(): void;
  fromAbove(): void;
  toggleSide(): void;
  toggleTheme(): void;
  savePicture(): void;
  help(): void;
  toggleLayer(key: string): void;
}
