#!/usr/bin/env python3
"""Writes scene/*.npy: the scene encoder (common/model/scene_encoder.h), and whole SAC updates with it, in float64.

Usage: /usr/bin/python3 tests/golden/make_scene_golden.py      (Debian's python3-torch; the tests need neither)

Written in PyTorch's own terms: each stage on its own tensors, without a graph or its gathering of rows.
"""
import math
import numpy as np
import torch
import torch.nn.functional as F
from make_golden import (BATCH, HISTORY, VEHICLES, actor_batch, make_ego, make_parameters, make_vehicles, save, tensor, uniform,
                         write_updates)

WAYS, POINTS = 2, 10


def make_polylines(k):
    """Ways of all lengths, absent ones among them."""
    lines = uniform(130 + k, (BATCH, WAYS * (1 + VEHICLES), POINTS, 5))
    b, w = np.mgrid[0:BATCH, 0:lines.shape[1]]
    present = np.arange(POINTS) < ((b * 3 + w * 5 + k) % 13)[..., None]
    lines[..., 0] = 0
    lines[~present] = [1, 0, 0, 0, 0]
    return lines


def attention_shapes(name, query, keys, heads, outputs):
    inner = heads * 128
    return [(name + '.query.weight', (query, inner), query), (name + '.query.bias', (inner,), query),
            (name + '.key.weight', (keys, inner), keys),
            (name + '.value.weight', (keys, inner), keys), (name + '.value.bias', (inner,), keys),
            (name + '.output.weight', (inner, outputs), inner), (name + '.output.bias', (outputs,), inner)]


def dense(p, name, x):
    y = x @ p[name + '.weight']
    return y + p[name + '.bias'] if name + '.bias' in p else y


def attend(p, name, query, keys, absent, heads):
    """query [..., Q, F], keys [..., K, F], absent [..., K]: [..., Q, outputs], rectified."""
    split = lambda x: x.reshape(*x.shape[:-1], heads, 128).transpose(-2, -3)
    q, k, v = split(dense(p, name + '.query', query)), split(dense(p, name + '.key', keys)), \
        split(dense(p, name + '.value', keys))
    hidden = absent[..., None, None, :]
    score = (q @ k.transpose(-1, -2) / math.sqrt(128)).masked_fill(hidden, -1e300)
    weight = torch.softmax(score, -1).masked_fill(hidden, 0.0)
    joined = (weight @ v).transpose(-2, -3)
    return F.relu(dense(p, name + '.output', joined.reshape(*joined.shape[:-2], heads * 128)))


def pool(x, absent):
    """The largest over what is there; nothing is negative."""
    return x.masked_fill(absent.unsqueeze(-1), 0.0).amax(-2)


class SceneEncoder:
    features = 128
    shapes = (attention_shapes('encoder.scene.time', 7, 7, 2, 128) +
              attention_shapes('encoder.scene.points', 5, 5, 2, 192) +
              [('encoder.scene.kind.weight', (2, 64), 2), ('encoder.scene.kind.bias', (64,), 2),
               ('encoder.scene.way.weight', (256, 128), 256), ('encoder.scene.way.bias', (128,), 256)] +
              attention_shapes('encoder.scene.local', 128, 128, 2, 128) +
              attention_shapes('encoder.scene.interaction', 128, 128, 2, 128) +
              attention_shapes('encoder.scene.goal', 128, 128, 1, 128))

    def __call__(self, p, k):
        e = 'encoder.scene.'
        vehicles, ego, lines = tensor(make_vehicles(50 + k)), tensor(make_ego(60 + k)), tensor(make_polylines(k))
        rows = torch.cat([ego[:, None, :, :7], vehicles], 1)  # [B, 1 + V, H, 7]
        absent = rows[..., 0] > 0.5
        agents = pool(attend(p, e + 'time', rows, rows, absent, 2), absent)
        gone = lines[..., 0] > 0.5
        along = pool(attend(p, e + 'points', lines, lines, gone, 2), gone)
        kind = torch.zeros(BATCH, lines.shape[1], 2)
        kind[:, :WAYS, 0] = 1
        kind[:, WAYS:, 1] = 1
        kind = F.relu(dense(p, e + 'kind', kind))
        ways = F.relu(dense(p, e + 'way', torch.cat([along, kind], -1))).reshape(BATCH, 1 + VEHICLES, WAYS, 128)
        no_way = gone[..., 0].reshape(BATCH, 1 + VEHICLES, WAYS)
        newest = absent[:, 1:, -1]
        near = agents[:, 1:, None]
        fused = attend(p, e + 'local', near, torch.cat([near, ways[:, 1:]], 2),
                       torch.cat([newest[..., None], no_way[:, 1:]], 2), 2)[:, :, 0]
        self_ego = agents[:, :1]
        around = attend(p, e + 'interaction', self_ego, torch.cat([self_ego, fused], 1), F.pad(newest, (1, 0)), 2)
        goal = attend(p, e + 'goal', around, ways[:, 0], no_way[:, 0], 1)
        return (around + goal)[:, 0]


class LatentPrediction:
    """Before each update: a step of the encoder and of the prediction of what it says one step later."""

    shapes = ([('action.weight', (2, 64), 2), ('action.bias', (64,), 2)] +
              attention_shapes('attention', 192, 192, 1, 128) +
              [('projector1.weight', (128, 256), 128), ('projector1.bias', (256,), 128),
               ('projector2.weight', (256, 128), 256), ('projector2.bias', (128,), 256),
               ('predictor.weight', (128, 128), 128), ('predictor.bias', (128,), 128)])

    def __init__(self, network):
        self.network = network
        self.p = make_parameters(4, self.shapes)
        self.adam = None
        self.losses = []

    def project(self, x):
        return F.relu(dense(self.p, 'projector2', F.relu(dense(self.p, 'projector1', x))))

    def __call__(self, k, critic):
        encoder = [v for n, v in critic.items() if n.startswith('encoder.')]
        if self.adam is None:
            self.adam = torch.optim.Adam(encoder + list(self.p.values()), lr=3e-4, eps=1e-5)
        action, _, discount, *_ = actor_batch(k)
        acted = torch.cat([self.network(critic, k), F.relu(dense(self.p, 'action', tensor(action)))], 1)
        # Attention over a single step.
        attended = dense(self.p, 'attention.output', dense(self.p, 'attention.value', acted))
        prediction = dense(self.p, 'predictor', self.project(attended))
        with torch.no_grad():
            target = self.project(self.network(critic, k + 1))
        followed = torch.tensor(discount > 0)
        loss = -F.cosine_similarity(prediction, target)[followed].mean()
        self.adam.zero_grad(set_to_none=True)
        loss.backward()
        self.adam.step()
        self.losses.append(loss.item())


if __name__ == '__main__':
    network = SceneEncoder()
    p = make_parameters(47, network.shapes)
    features = network(p, 0)
    features.backward(tensor(uniform(48, tuple(features.shape))))
    save('scene/output', features)
    save('scene/gradient', np.concatenate([v.grad.numpy().ravel()[::31] for v in p.values()]))
    write_updates('scene/update', True, network, True, 1e-3, extras=('parameters',), step=31)
    latent = LatentPrediction(network)
    write_updates('slt', True, network, True, 1e-5, extras=('parameters',), step=31, before=latent)
    save('slt/latent_losses', latent.losses)
    save('slt/latent', np.concatenate([v.detach().numpy().ravel()[::31] for v in latent.p.values()]))
